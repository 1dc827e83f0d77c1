"""Gap and pressure along the middle of the finger over a period, as a table.

squeezefilm cross-section SCENES.csv --config CONFIG.yaml --output FILM.csv
"""

import argparse

import pandas as pd

from reporting.cross_section import cross_section
from squeezefilm.io.tables import read_scenes, scene_points, write_table
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.reynolds import node_cache
from squeezefilm.reynolds.device import choose_device
from squeezefilm.studies.config import load_config
from squeezefilm.studies.study import scene_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", metavar="SCENES.csv", help="the scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="FILM.csv", help="table to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    points = scene_points(read_scenes(options.scenes))
    with node_cache.one_build_at_a_time():
        device = choose_device(config["solver"]["device"])
    scenes = resolve_auto_terms(
        [scene_of(point, config) for point in points],
        model_tolerance=config["solver"]["model_tolerance"],
        device=device,
    )
    films = [cross_section(scene, device=device) for scene in scenes]
    write_table(pd.concat(films, ignore_index=True), options.output)
