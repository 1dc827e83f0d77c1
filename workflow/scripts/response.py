"""Write how the forces of a plan follow a changing amplitude."""

import numpy as np

from scripts.job import begin_with_study
from squeezefilm.dynamics.response import all_gains, responses
from squeezefilm.studies.solver_settings import device_of, solver_settings
from squeezefilm.studies.study import scenes_in
from squeezefilm.tables import read_scenes, write_table

FREQUENCY_HZ = np.array([3, 10, 30, 60, 100, 150, 200, 300, 500, 700, 1e3, 2e3, 4e3])

snakemake, config = begin_with_study()
table = read_scenes(snakemake.input.scenes)
scenes, tolerance = scenes_in(table, config), solver_settings(config, outputs=()).tolerance
found = responses(table, scenes, tolerance=tolerance, device=device_of(config))
write_table(found, snakemake.output.response)
write_table(all_gains(table, scenes, FREQUENCY_HZ), snakemake.output.gains)
