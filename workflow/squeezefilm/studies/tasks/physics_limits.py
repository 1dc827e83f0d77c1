"""The asymptotic forces of a study's scenes, without solving in time or fitting, and a table.

`fast_limit_n` is the force at infinite squeeze number, `limit_n` the same with the boundary layer
at the pad's edge, correct to 1/√σ, `limit_error_n` the estimate of its error. With the
gas' inertia the next order is ε²/σ, without it ε²/σ^(3/2): there `limit_n` is the composite that
is exact to ε². A scene whose inertia is `auto` counts as having it, for limits cost the same.
"""

from collections.abc import Sequence
from itertools import product
from math import prod

import numpy as np
import pandas as pd
from numpy.polynomial import chebyshev

from squeezefilm.config.study import Study
from squeezefilm.errors import InputError
from squeezefilm.film.scene import Scene
from squeezefilm.models.data import PHYSICS_COLUMN_OF_NAME, factors_of_table
from squeezefilm.models.force_model import ExpressionModel
from squeezefilm.models.limit_table import LimitTable
from squeezefilm.reynolds.asymptotics.composite import (
    composite_expansion,
    edge_layer_expansion,
    expand_scenes,
    high_squeeze_limit,
    reasons_not_expanded,
)
from squeezefilm.reynolds.plan import solve_plan_of
from squeezefilm.studies.space import plan_table, space_of_study
from squeezefilm.studies.study import scenes_of_table

LIMIT_TOLERANCE, LIMIT_TOLERANCE_WITH_INERTIA = 1e-8, 1e-6
"""Of the limits' grids, which are cheap: far below the error of the limits."""
EXPANSION_OF_COLUMN = {"fast_limit_n": high_squeeze_limit, "limit_n": edge_layer_expansion}
INERTIA_EXPANSION_OF_COLUMN = EXPANSION_OF_COLUMN | {"limit_n": composite_expansion}
EXPANSION_INVALID_STATUS = (
    "not supported: the asymptotic force for large squeeze numbers does not hold"
)
TABLE_CHECK_POINTS, TABLE_CHECK_SEED = 500, 3
PROBE_LINES_PER_AXIS, POINTS_PER_PROBE_LINE = 3, 65
"""Along each axis of a table, at random places of the others, to choose its points, and Chebyshev
points of a line, by which the decay of coefficients is measured."""
MIN_POINTS_PER_AXIS, MAX_TABLE_NODES = 3, 15_000
"""Of an axis; of a table, whose file grows with them."""
MAX_EPSILON_SQUARE = 0.5
"""Amplitudes up to 0.7 of the gap: beyond a study's, since a target force may lie there."""
TABLE_TOLERANCE, TABLE_TOLERANCE_WITH_INERTIA = 3e-7, 1e-5
"""Of a table, relative; the best fitted corrections of the limits leave 3e-5 of the force."""


def with_asymptotic_forces(table: pd.DataFrame, scenes: Sequence[Scene]) -> pd.DataFrame:
    """A table of scenes with its limits in newtons; NaN where they do not hold."""
    films = solve_plan_of(
        [s.with_gas(inertia="included") if s.gas.inertia == "auto" else s for s in scenes]
    )
    underived = reasons_not_expanded(films)
    derived = ~np.isin(np.arange(len(scenes)), list(underived))
    has = np.broadcast_to(films.scenes.gas.inertia == "included", len(scenes))
    scale_n = np.broadcast_to(films.scenes.force_scale_n, len(scenes))
    columns = {"sigma": films.scenes.sigma}
    columns |= {
        name: np.full(len(scenes), np.nan) for name in (*EXPANSION_OF_COLUMN, "limit_error_n")
    }
    for inertia, column in product((False, True), EXPANSION_OF_COLUMN):
        expand = (INERTIA_EXPANSION_OF_COLUMN if inertia else EXPANSION_OF_COLUMN)[column]
        found = expand_scenes(
            expand,
            films,
            np.flatnonzero(derived & (has == inertia)),
            tolerance=LIMIT_TOLERANCE_WITH_INERTIA if inertia else LIMIT_TOLERANCE,
            layers=expand is composite_expansion,
        )
        found = found[np.isfinite(found.pressure_ratio_error)]
        columns[column][found.scene_rows] = found.mean_pressure_ratio * scale_n[found.scene_rows]
        if column == "limit_n":
            columns["limit_error_n"][found.scene_rows] = (
                found.pressure_ratio_error * scale_n[found.scene_rows]
            )
    status = [
        "ok" if known else underived.get(row, EXPANSION_INVALID_STATUS)
        for row, known in enumerate(np.isfinite(columns["limit_n"]))
    ]
    return table.assign(**columns, status=status)


def with_limit_forces(model: ExpressionModel, points: pd.DataFrame, config: Study) -> pd.DataFrame:
    """Points with the asymptotic forces that a model uses, computed unless the table has them.

    With the status of these, in place of that of the points' own forces.
    """
    if not set(model.column_names) - set(points):
        return points
    limits = with_asymptotic_forces(points, scenes_of_table(points, config))
    return points.assign(**limits[[*PHYSICS_COLUMN_OF_NAME.values(), "status"]])


def limit_table_of_study(config: Study) -> LimitTable:
    """The table of a study's limits, checked at random points.

    A limit over ε² is smooth; how many Chebyshev points each factor needs is measured on a few
    lines through the space, for over the position it bends as often as the profile.

    Raises InputError where the limits do not hold all over the space.
    """
    ranges = dict(space_of_study(config).limits)
    del ranges["hv_m"]
    epsilon_square = {"epsilon_square": (0.0, MAX_EPSILON_SQUARE)}
    ranges = {"h0_m": ranges.pop("h0_m"), **epsilon_square, **ranges}
    random = np.random.default_rng(TABLE_CHECK_SEED)
    counts = _node_counts(config, ranges, random)
    nodes = np.meshgrid(
        *[_chebyshev_points(ranges[axis], counts[axis]) for axis in ranges], indexing="ij"
    )
    shape = nodes[0].shape
    limits, smooth = _asymptotic_forces_at(
        config, dict(zip(ranges, map(np.ravel, nodes), strict=True))
    )
    coefficients = {}
    for name, values in zip(EXPANSION_OF_COLUMN, smooth, strict=True):
        transformed = values.reshape(shape)
        for axis in range(len(shape)):
            transformed = _chebyshev_coefficients(transformed, axis=axis)
        coefficients[name] = transformed.ravel().tolist()
    values = {
        "ranges": ranges,
        "shape": shape,
        "coefficients": coefficients,
        "sigma_h0_square_m2": limits["sigma"].iloc[0] * limits["h0_m"].iloc[0] ** 2,
        "largest_relative_error": np.nan,
    }
    table = LimitTable.model_validate(values)
    drawn = {axis: random.uniform(*ranges[axis], TABLE_CHECK_POINTS) for axis in ranges}
    drawn["epsilon_square"] = np.maximum(drawn["epsilon_square"], 1e-6)
    checked, _ = _asymptotic_forces_at(config, drawn)
    interpolated = table.with_asymptotic_forces(factors_of_table(checked))
    errors = [
        np.abs(interpolated.column(name) / checked[name] - 1).max() for name in EXPANSION_OF_COLUMN
    ]
    return table.model_copy(update={"largest_relative_error": float(max(errors))})


def _node_counts(
    config: Study, ranges: dict[str, tuple[float, float]], random: np.random.Generator
) -> dict[str, int]:
    """Points that each axis of the table needs, measured on lines along it at random places.

    The error of m points is Σ |c_k|, k ≥ m, over the mean value, the largest of all lines. One
    more is taken where it is largest, until all hold the tolerance or there are MAX_TABLE_NODES.
    """
    tails = {}
    for along, (low, high) in ranges.items():
        if low == high:
            continue
        at = {
            axis: np.repeat(random.uniform(*limits, PROBE_LINES_PER_AXIS), POINTS_PER_PROBE_LINE)
            for axis, limits in ranges.items()
        }
        at[along] = np.tile(
            _chebyshev_points(ranges[along], POINTS_PER_PROBE_LINE), PROBE_LINES_PER_AXIS
        )
        lines = _asymptotic_forces_at(config, at)[1].reshape(-1, POINTS_PER_PROBE_LINE)
        sizes = np.abs(_chebyshev_coefficients(lines, axis=1)) / np.abs(lines).mean(
            axis=1, keepdims=True
        )
        tail = np.flip(np.cumsum(np.flip(sizes, axis=1), axis=1), axis=1).max(axis=0)
        tails[along] = np.append(tail, 0.0)
    inertia = config.gas.inertia != "none"
    tolerance = TABLE_TOLERANCE_WITH_INERTIA if inertia else TABLE_TOLERANCE
    counts = {axis: MIN_POINTS_PER_AXIS if axis in tails else 1 for axis in ranges}

    def tail_beyond_node_count(axis: str) -> float:
        return float(tails[axis][counts[axis]])

    while tail_beyond_node_count(widest := max(tails, key=tail_beyond_node_count)) > tolerance:
        if prod(counts.values()) // counts[widest] * (counts[widest] + 1) > MAX_TABLE_NODES:
            break
        counts[widest] += 1
    return counts


def _chebyshev_points(limits: tuple[float, float], count: int) -> np.ndarray:
    """Chebyshev points between two limits."""
    low, high = limits
    return (low + high) / 2 + (high - low) / 2 * chebyshev.chebpts1(count)


def _chebyshev_coefficients(values: np.ndarray, *, axis: int) -> np.ndarray:
    """Chebyshev coefficients along an axis of values at the points."""
    points = values.shape[axis]
    at_nodes = chebyshev.chebvander(chebyshev.chebpts1(points), points - 1)
    moved = np.tensordot(np.linalg.inv(at_nodes), values, axes=(1, axis))
    return np.moveaxis(moved, 0, axis)


def _asymptotic_forces_at(
    config: Study, at: dict[str, np.ndarray]
) -> tuple[pd.DataFrame, np.ndarray]:
    """The limits at points, and both EXPANSION_OF_COLUMN over ε², which is smooth, shape (2, n)."""
    factors = pd.DataFrame(at).assign(hv_m=at["h0_m"] * np.sqrt(at["epsilon_square"]))
    table = plan_table(factors.drop(columns="epsilon_square"))
    limits = with_asymptotic_forces(table, scenes_of_table(table, config))
    if missing := [status for status in limits["status"] if status != "ok"]:
        raise InputError(f"{config.path}: {missing[0]} (of the study's space)")
    return limits, limits[[*EXPANSION_OF_COLUMN]].to_numpy().T / at["epsilon_square"]
