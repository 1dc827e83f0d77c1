"""Time of all of some plans' scenes in one call, and of the same algorithm in NumPy.

python -m numerics batch-times SCENES.csv … --config CONFIG.yaml --output TABLE.csv

Warm, error estimates included; medians of repeats. NumPy solves each scene once, on 24 × 24 × 16
points of the whole finger, without an error estimate.
"""

import argparse
from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd

from numerics.peers.numpy_periodic import periodic_force
from numerics.peers.yardstick import YardstickResult
from numerics.timing import measure
from squeezefilm.film.scene import Scene
from squeezefilm.io.tables import read_scenes, scene_points, write_table
from squeezefilm.reynolds.solver import solve
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.studies.study import scene_of

COLUMNS = ("solver", "tolerance", "left_to_limits", "cpu_s", "wall_s")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", nargs="+", metavar="SCENES.csv", help="tables of scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")
    parser.add_argument(
        "--tolerance", type=float, nargs="+", default=[1e-6, 1e-5, 1e-4, 1e-2], help="relative"
    )
    parser.add_argument("--repeats", type=int, default=9, metavar="N", help="9 if left out")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    points = [point for path in options.scenes for point in scene_points(read_scenes(path))]
    scenes = [scene_of(point, config) for point in points]
    device = device_of(config)
    solve(scenes, tolerance=min(options.tolerance), device=device)  # kernels are built once
    rows = []
    for tolerance in options.tolerance:
        call = partial(solve, scenes, tolerance=tolerance, device=device)
        timed = measure(call, repeats=options.repeats)
        limits = sum(each.method != "periodic" for each in timed.result)
        rows.append((device.name, tolerance, limits, timed.cpu_seconds, timed.wall_seconds))
    numpy = measure(partial(in_numpy, scenes), repeats=1)
    rows.append(("NumPy", float("nan"), 0, numpy.cpu_seconds, numpy.wall_seconds))
    table = pd.DataFrame(rows, columns=COLUMNS).assign(scenes=len(scenes))
    write_table(table, options.output)
    print(table.to_string(index=False))


def in_numpy(scenes: Sequence[Scene]) -> list[YardstickResult]:
    """Solve scenes of the plain equation one by one."""
    return [
        periodic_force(
            epsilon=scene.epsilon,
            sigma=scene.sigma,
            amplitude=partial(profile_of, scene),
            nx=24,
            ny=24,
            nt=16,
            tolerance=1e-6,
        )
        for scene in scenes
    ]


def profile_of(scene: Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The shape of the vibration across the finger."""
    return scene.parts(x, y)[0]
