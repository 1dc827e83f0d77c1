"""Put back, one at a time, what scenes do not need: the same forces, at what cost.

squeezefilm left-out SCENES.csv --config CONFIG.yaml --output LEFT_OUT.csv
"""

import argparse

import pandas as pd

from numerics.left_out import Variant, measure
from squeezefilm.io.errors import RunError
from squeezefilm.io.tables import read_scenes, scene_points, write_table
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.studies.study import scene_of

TOLERANCES = (1e-2, 1e-4, 1e-6)
REFERENCE = 1e-9


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", nargs="+", metavar="SCENES.csv", help="samples of scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="LEFT_OUT.csv", help="table to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    device = device_of(config)
    points = [point for path in options.scenes for point in scene_points(read_scenes(path))]
    variants = measure(
        [scene_of(point, config) for point in points],
        tolerances=TOLERANCES,
        reference=REFERENCE,
        repeats=config["numerics"]["repeats"],
        device=device,
    )
    table = pd.DataFrame([vars(variant) for variant in variants])
    note = (
        f"{len(points)} scenes, each judged by the periodic state at tolerance {REFERENCE:g}; "
        f"processor time of all threads, median of {config['numerics']['repeats']} repeats, error "
        f"estimates included; {device.name}, double precision."
    )
    write_table(table.assign(device=device.name, note=note), options.output)
    print(table.to_string(index=False))
    wrong = [each for each in variants if not _holds(each)]
    if wrong:
        names = ", ".join(f"{each.put_back or 'as needed'} at {each.tolerance:g}" for each in wrong)
        raise RunError(f"error above the tolerance, or estimates that do not cover it: {names}")


def _holds(variant: Variant) -> bool:
    """The promise to a user: no error above the tolerance, and estimates honest in 99 %."""
    return variant.worst_error <= variant.tolerance and variant.covered >= 0.99
