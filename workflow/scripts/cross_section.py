"""Write gap and pressure along the middle of the finger over a period."""

import pandas as pd

from reporting.cross_section import cross_section
from scripts.job import begin
from squeezefilm.io.tables import read_scenes, scene_points, write_table
from squeezefilm.reynolds.effects.automatic import decided
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.studies.study import scene_of

snakemake = begin()
config = load_config(snakemake.config["study_file"])
device = device_of(config)
scenes = decided(
    [scene_of(point, config) for point in scene_points(read_scenes(snakemake.input.scenes))],
    model_tolerance=config["solver"]["model_tolerance"],
    device=device,
)
films = [cross_section(scene, device=device) for scene in scenes]
write_table(pd.concat(films, ignore_index=True), snakemake.output[0])
