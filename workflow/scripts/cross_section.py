"""Write gap and pressure along the middle of the finger over a period."""

import pandas as pd

from reporting.cross_section import cross_section
from scripts.job import begin_with_study
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.studies.study import scenes_in
from squeezefilm.tables import read_scenes, write_table

snakemake, config = begin_with_study()
device = device_of(config)
scenes = resolve_auto_terms(
    scenes_in(read_scenes(snakemake.input.scenes), config),
    model_tolerance=config["solver"]["model_tolerance"],
    device=device,
)
films = [cross_section(scene, device=device) for scene in scenes]
write_table(pd.concat(films, ignore_index=True), snakemake.output[0])
