"""What `auto` leaves out of random scenes, and how far including it moves their forces.

squeezefilm auto-terms --config CONFIG.yaml --output TABLE.csv [--scenes N] [--seed S]

The scenes are those of the command `inertia`, of any Re; a row for each term and model tolerance.
"""

import argparse
from math import inf

import pandas as pd

from numerics.inertia.random_scenes import moved_by_leaving_out, random_scenes
from squeezefilm.io.tables import ScenePoint, write_table
from squeezefilm.reynolds.effects.automatic import OPEN
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.studies.study import scene_of

SEED = 51
MODEL_TOLERANCES = (1e-3, 1e-2, 3e-2)
# Of the forces, as a share of the model tolerance.
SHARE = 0.03


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")
    parser.add_argument("--scenes", type=int, default=300, metavar="N", help="300 if left out")
    parser.add_argument("--seed", type=int, default=SEED, help=f"{SEED} if left out")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    scenes = random_scenes(
        scene_of(ScenePoint("1", 5e-6, 0.0), config),
        count=options.scenes,
        seed=options.seed,
        reynolds=(0.0, inf),
        inertia="auto",
        heat="auto",
    )
    device = device_of(config)
    rows = []
    for term in OPEN:
        for allowed in MODEL_TOLERANCES:
            left_out, moved = moved_by_leaving_out(
                scenes,
                term=term,
                model_tolerance=allowed,
                tolerance=SHARE * allowed,
                device=device,
            )
            rows.append(
                {
                    "term": term,
                    "model_tolerance": allowed,
                    "scenes": len(scenes),
                    "left_out": left_out,
                    "known": len(moved),
                    "most_moved": moved.max(initial=0.0),
                }
            )
    table = pd.DataFrame(rows)
    write_table(table.assign(device=device.name), options.output)
    print(table.to_string(index=False))
