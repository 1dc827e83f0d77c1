"""Write how the forces of a plan follow a changing amplitude."""

import numpy as np

from scripts.job import begin_with_study
from squeezefilm.cli.use.response import all_gains, summaries, table_and_scenes
from squeezefilm.studies.solver_settings import device_of, solver_settings
from squeezefilm.tables import write_table

FREQUENCY_HZ = np.array([3, 10, 30, 60, 100, 150, 200, 300, 500, 700, 1e3, 2e3, 4e3])

snakemake, config = begin_with_study()
settings = solver_settings(config, outputs=())
table, scenes = table_and_scenes(snakemake.input.scenes, config)
write_table(summaries(table, scenes, settings, device_of(config)), snakemake.output.response)
write_table(all_gains(table, scenes, FREQUENCY_HZ), snakemake.output.gains)
