"""Write the physics limit of each scene of a table: its force without solving in time or fitting.

  squeezefilm limits SCENES.csv --config C.yaml --output LIMITS.csv

`fast_limit_n` is the force at infinite squeeze number, `limit_n` the same with the boundary layer
at the finger's rim, correct to 1/√σ, `limit_error_n` the estimate of what that leaves out, and
`sigma` the squeeze number. Models may use these columns beside the factors. Where the limit does
not hold, the numbers are left out and `status` says so.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
import pandas as pd

from squeezefilm.film.scene import Scene
from squeezefilm.io.tables import LIMIT_COLUMNS, read_scenes, scene_points, write_table
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.solver import by_limits
from squeezefilm.studies.config import load_config
from squeezefilm.studies.study import scene_of

SECTIONS = ("gas", "actuator", "finger")
TOLERANCE = 1e-8
"""Of the limits' grids, which are cheap: far below what the limits leave out."""
METHODS = {"fast_limit_n": "fast-limit", "limit_n": "boundary-layer"}
DOES_NOT_HOLD = "the limit of large squeeze numbers does not hold for this scene"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", metavar="SCENES.csv", help="table of scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="LIMITS.csv", help="table to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config).only(SECTIONS)
    table = read_scenes(options.scenes)
    scenes = [scene_of(point, config) for point in scene_points(table)]
    write_table(with_limits(table, scenes)[list(LIMIT_COLUMNS)], options.output)


def with_limits(table: pd.DataFrame, scenes: Sequence[Scene]) -> pd.DataFrame:
    """A table of scenes with its limits in newtons; NaN where they do not hold."""
    needs = [needs_of(scene) for scene in scenes]
    columns = {"sigma": np.array([scene.sigma for scene in scenes])}
    errors: dict[str, np.ndarray] = {}
    for column, method in METHODS.items():
        columns[column], errors[column] = np.full((2, len(scenes)), np.nan)
        found = by_limits(scenes, needs, tolerance=TOLERANCE, method=method)
        for index, result in found.items():
            if np.isfinite(result.error):
                columns[column][index] = result.mean * scenes[index].force_scale_n
                errors[column][index] = result.error * scenes[index].force_scale_n
    status = np.where(np.isfinite(columns["limit_n"]), "ok", DOES_NOT_HOLD)
    return table.assign(**columns, limit_error_n=errors["limit_n"], status=status)
