"""Write the gaps that carry loads as in a plan."""

import pandas as pd

from scripts.job import begin
from squeezefilm.api.forces import scan_error_of
from squeezefilm.api.study import load
from squeezefilm.dynamics.tables import levitations, loads_like
from squeezefilm.film.validity import GAPS_M
from squeezefilm.studies.solver_settings import solver_settings
from squeezefilm.tables import write_table

snakemake = begin()
study = load(snakemake.config["study_file"])
loads_n, amplitudes_m = loads_like(snakemake.input.forces)
scenes = study.scenes(pd.DataFrame({"hv_m": amplitudes_m, "h0_m": GAPS_M[1]}))
settings = solver_settings(study.config)
how = settings.how(study.device) | {"model_tolerance": settings.model_tolerance}
scan_error_n = scan_error_of(study.scan, device=study.device)
table, *_ = levitations(scenes, loads_n, how=how, scan_error_n=scan_error_n)
write_table(table, snakemake.output[0])
