"""The physics limits of a study's scenes: forces without solving in time or fitting, and a table.

`fast_limit_n` is the force at infinite squeeze number, `limit_n` the same with the boundary layer
at the finger's rim, correct to 1/√σ, `limit_error_n` the estimate of what that leaves out.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import FACTOR_COLUMNS, scene_points
from squeezefilm.models.force_model import Factors
from squeezefilm.models.limit_table import (
    LARGEST_EPSILON_SQUARE,
    LimitTable,
    coefficients_of,
    nodes,
)
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.solver import by_limits
from squeezefilm.studies.config import Config
from squeezefilm.studies.plans import box_of, plan
from squeezefilm.studies.study import scene_of

TOLERANCE = 1e-8
"""Of the limits' grids, which are cheap: far below what the limits leave out."""
METHODS = {"fast_limit_n": "fast-limit", "limit_n": "boundary-layer"}
DOES_NOT_HOLD = "the limit of large squeeze numbers does not hold for this scene"
CHECK_POINTS, CHECK_SEED = 500, 3


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


def limit_table_of(config: Config) -> LimitTable:
    """The table of a study's limits, checked at random points.

    Raises InputError where the limits do not hold all over the space.
    """
    box = box_of(config).ranges
    box.pop("hv_m")
    ranges = box | {"epsilon_square": (0.0, LARGEST_EPSILON_SQUARE)}
    at, shape = nodes(ranges)
    limits = _limits(config, at)
    square = at["epsilon_square"].reshape(shape)
    table = LimitTable(
        ranges=ranges,
        coefficients={
            name: coefficients_of(limits[name].to_numpy().reshape(shape) / square)
            for name in METHODS
        },
        sigma_h0_square=float(limits["sigma"].iloc[0] * limits["h0_m"].iloc[0] ** 2),
        error=np.nan,
    )
    random = np.random.default_rng(CHECK_SEED)
    drawn = {axis: random.uniform(*ranges[axis], CHECK_POINTS) for axis in ranges}
    drawn["epsilon_square"] = np.maximum(drawn["epsilon_square"], 1e-6)
    checked = _limits(config, drawn)
    found = table.complete(Factors.of(**{name: checked[name] for name in FACTOR_COLUMNS}))
    errors = [np.abs(found.column(name) / checked[name] - 1).max() for name in METHODS]
    return replace(table, error=float(max(errors)))


def _limits(config: Config, at: dict[str, np.ndarray]) -> pd.DataFrame:
    table = plan(
        h0_m=at["h0_m"],
        hv_m=at["h0_m"] * np.sqrt(at["epsilon_square"]),
        phi_r_m=at["phi_r_m"],
        phi_deg=at["phi_deg"],
    )
    limits = with_limits(table, [scene_of(point, config) for point in scene_points(table)])
    if not np.all(np.isfinite(limits[list(METHODS)])):
        raise InputError(f"{config.path}: {DOES_NOT_HOLD}, or another of the study's space")
    return limits
