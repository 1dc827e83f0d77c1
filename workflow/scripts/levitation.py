"""Write the gaps that carry loads as in a plan."""

import pandas as pd

from scripts.job import begin_with_study
from squeezefilm.api.film import Film
from squeezefilm.api.forces import scan_error_of
from squeezefilm.dynamics.levitation import levitations, loads_like
from squeezefilm.film.validity import GAPS_M
from squeezefilm.studies.solver_settings import solver_settings
from squeezefilm.tables import write_table

snakemake, config = begin_with_study()
film = Film(config)
loads_n, amplitudes_m = loads_like(snakemake.input.forces)
scenes = film.scenes(pd.DataFrame({"hv_m": amplitudes_m, "h0_m": GAPS_M[1]}))
settings = solver_settings(film.config)
how = settings.how(film.device) | {"model_tolerance": settings.model_tolerance}
scan_error_n = scan_error_of(film.scan, device=film.device)
table, *_ = levitations(scenes, loads_n, how=how, scan_error_n=scan_error_n)
write_table(table, snakemake.output[0])
