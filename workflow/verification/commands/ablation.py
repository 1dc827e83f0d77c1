"""Put back, one at a time, what scenes do not need: the same forces, at what cost.

  squeezefilm ablation SCENES.csv … --config CONFIG.yaml --output ABLATION.csv

All scenes are solved in one call; times are of a warm process, error estimates included.
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.io.errors import RunError
from squeezefilm.io.tables import read_scenes, scene_points, write_table
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.studies.study import scene_of
from verification.ablation import ablation

TOLERANCES = (1e-2, 1e-4, 1e-6)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", nargs="+", metavar="SCENES.csv", help="samples of scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="ABLATION.csv", help="table to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    device = device_of(config)
    points = [point for path in options.scenes for point in scene_points(read_scenes(path))]
    scenes = [scene_of(point, config) for point in points]
    repeats = config["numerics"]["repeats"]
    table = ablation(scenes, tolerances=TOLERANCES, repeats=repeats, device=device)
    write_table(table.assign(repeats=repeats, device=device.name), options.output)
    print(table.to_string(index=False))
    # The promise to a user: no error above the tolerance, and estimates honest in 99 %.
    judged = table[table["covered"].notna()]
    wrong = judged[(judged["worst_error"] > judged["tolerance"]) | (judged["covered"] < 0.99)]
    if len(wrong):
        names = ", ".join(f"{row.put_back} at {row.tolerance:g}" for row in wrong.itertuples())
        raise RunError(f"error above the tolerance, or estimates that do not cover it: {names}")
