"""Processor time of a plan's budget beside that of its forces, and of these with inertia.

squeezefilm term-costs SCENES.csv --config CONFIG.yaml --output TABLE.csv [--tolerance T ...]

Medians of repeats, all taken by turns in one run.
"""

import argparse

import pandas as pd

from numerics.inertia.costs import costs
from squeezefilm.io.tables import read_scenes, scene_points, write_table
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.studies.study import scene_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", metavar="SCENES.csv", help="table of scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")
    parser.add_argument("--tolerance", type=float, nargs="+", default=[1e-4, 1e-6], help="relative")
    parser.add_argument("--repeats", type=int, default=9, metavar="N", help="9 if left out")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    scenes = [scene_of(point, config) for point in scene_points(read_scenes(options.scenes))]
    device = device_of(config)
    rows = [
        costs(scenes, tolerance=tolerance, repeats=options.repeats, device=device).row
        for tolerance in options.tolerance
    ]
    table = pd.DataFrame(rows)
    write_table(table.assign(device=device.name), options.output)
    print(table.to_string(index=False))
