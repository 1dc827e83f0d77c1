"""Write the gaps that carry loads as in a plan."""

import pandas as pd

from scripts.job import begin_with_study
from squeezefilm.cli.use.levitate import levitations, like, points_at
from squeezefilm.studies.solver_settings import device_of, solver_settings
from squeezefilm.tables import write_table

snakemake, config = begin_with_study()
loads_n, amplitudes_m = like(snakemake.input.forces)
settings = solver_settings(config)
how = settings.how(device_of(config)) | {"model_tolerance": settings.model_tolerance}
table, *_ = levitations(loads_n, points_at(pd.DataFrame({"hv_m": amplitudes_m})), config, how)
write_table(table, snakemake.output[0])
