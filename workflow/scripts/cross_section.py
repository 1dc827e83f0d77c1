"""Write gap and pressure along the middle of the finger over a period."""

import pandas as pd

from reporting.cross_section import cross_section
from scripts.job import begin_with_study
from squeezefilm.studies.solver_settings import device_of, solver_settings
from squeezefilm.studies.study import scenes_in
from squeezefilm.tables import read_scenes, write_table

snakemake, config = begin_with_study()
device, scenes = device_of(config), scenes_in(read_scenes(snakemake.input.scenes), config)
resolved = solver_settings(config, outputs=()).resolved(scenes, device)
films = [cross_section(scene, device=device) for scene in resolved]
write_table(pd.concat(films, ignore_index=True), snakemake.output[0])
