"""Forces with inertia, and heat, on random scenes: held against finer grids, and what they cost.

squeezefilm inertia --config CONFIG.yaml --output TABLE.csv [--scenes N] [--seed S] [--heat]

Gaps of 1 to 30 µm, 5 to 100 kHz, excursion ratios of 0.01 to 0.8, any position, Re up to 10 or
between two others.
"""

import argparse

import pandas as pd

from numerics.inertia.random_scenes import against_a_finer_grid, random_scenes
from squeezefilm.io.tables import ScenePoint, write_table
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.studies.study import scene_of

REYNOLDS = (0.0, 10.0)
SEED = 11


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")
    parser.add_argument("--scenes", type=int, default=200, metavar="N", help="200 if left out")
    parser.add_argument("--seed", type=int, default=SEED, help=f"{SEED} if left out")
    parser.add_argument(
        "--reynolds", type=float, nargs=2, default=REYNOLDS, metavar=("LEAST", "MOST"), help="Re"
    )
    parser.add_argument("--tolerance", type=float, nargs="+", default=[1e-3, 1e-4], help="relative")
    parser.add_argument("--heat", action="store_true", help="with heat too")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    like = scene_of(ScenePoint("1", 5e-6, 0.0), config)
    scenes = random_scenes(
        like,
        count=options.scenes,
        seed=options.seed,
        reynolds=tuple(options.reynolds),
        inertia="included",
        heat="included" if options.heat else "none",
    )
    device = device_of(config)
    found = [
        against_a_finer_grid(scenes, tolerance=tolerance, device=device)[0]
        for tolerance in options.tolerance
    ]
    table = pd.DataFrame([vars(each) for each in found])
    write_table(table.assign(device=device.name), options.output)
    print(table.to_string(index=False))
