"""Tabulate the physics limits over a study's space, for the files of models that use them.

  squeezefilm limit-table --config C.yaml --output TABLE.json

`squeezefilm fit … --limit-table TABLE.json` puts the table into the fit's file. It holds gaps and
positions of the study's space and amplitudes up to 0.7 of the gap, as polynomials; their largest
error is stated, from random points of the space.
"""

from __future__ import annotations

import argparse

import numpy as np
import pandas as pd

from squeezefilm.cli.steps.limits import DOES_NOT_HOLD, METHODS, with_limits
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import scene_points, write_json
from squeezefilm.models.force_model import Factors
from squeezefilm.models.limit_table import (
    LARGEST_EPSILON_SQUARE,
    LimitTable,
    coefficients_of,
    nodes,
)
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.plans import factor_ranges, plan
from squeezefilm.studies.study import scene_of

SECTIONS = ("gas", "actuator", "finger", "screen", "positions")
CHECK_POINTS, CHECK_SEED = 500, 3


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.json", help="file to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config).only(SECTIONS)
    try:
        values = tabulate(config).to_dict()
    except InputError as error:
        values = {"refused": str(error)}
        print(error)
    write_json(values, options.output)


def tabulate(config: Config) -> LimitTable:
    """The table of a study's limits, checked at random points.

    Raises:
        InputError: where the limits do not hold all over the space.
    """
    box = factor_ranges(config)
    box.pop("hv_m")
    ranges = box | {"epsilon_square": (0.0, LARGEST_EPSILON_SQUARE)}
    at, shape = nodes(ranges)
    limits = _limits(config, at)
    square = at["epsilon_square"].reshape(shape)
    coefficients = {
        name: coefficients_of(limits[name].to_numpy().reshape(shape) / square) for name in METHODS
    }
    table = LimitTable(
        ranges=ranges,
        coefficients=coefficients,
        sigma_h0_square=float(limits["sigma"].iloc[0] * limits["h0_m"].iloc[0] ** 2),
        error=np.nan,
    )
    random = np.random.default_rng(CHECK_SEED)
    drawn = {axis: random.uniform(*ranges[axis], CHECK_POINTS) for axis in ranges}
    drawn["epsilon_square"] = np.maximum(drawn["epsilon_square"], 1e-6)
    checked = _limits(config, drawn)
    found = table.complete(
        Factors.of(**{name: checked[name] for name in ("h0_m", "hv_m", "phi_r_m", "phi_deg")})
    )
    errors = [np.abs(found.column(name) / checked[name] - 1).max() for name in METHODS]
    return LimitTable(ranges, coefficients, table.sigma_h0_square, error=float(max(errors)))


def _limits(config: Config, at: dict[str, np.ndarray]) -> pd.DataFrame:
    table = plan(
        h0_m=at["h0_m"],
        hv_m=at["h0_m"] * np.sqrt(at["epsilon_square"]),
        phi_r_m=at["phi_r_m"],
        phi_deg=at["phi_deg"],
    )
    scenes = [scene_of(point, config) for point in scene_points(table)]
    limits = with_limits(table, scenes)
    if not np.all(np.isfinite(limits[list(METHODS)])):
        raise InputError(f"{config.path}: {DOES_NOT_HOLD}, or another of the study's space")
    return limits
