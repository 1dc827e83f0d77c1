"""Optimal designs of a study: certified ones, and how good other plans are beside them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.config.study import OptimalDesigns, Study
from squeezefilm.designs.optimal import (
    ContinuousDesign,
    GradientFunction,
    exact_design_by_exchange,
    log_determinant,
    maximin_design,
    optimal_approximate_design,
    optimal_design_in_space,
    sensitivity,
)
from squeezefilm.designs.space import coordinate_function
from squeezefilm.errors import InputError
from squeezefilm.film.positions import CARTESIAN_COLUMNS
from squeezefilm.models.data import RANGE_TOLERANCE, Factors, factors_of_table
from squeezefilm.models.fit_file import FittedModel
from squeezefilm.models.fitting import local_fit_theta, parameter_ranges
from squeezefilm.models.force_model import check_columns_known
from squeezefilm.parallel import track_progress
from squeezefilm.studies.space import plan_table, points_of_table, space_of_study, table_of_points
from squeezefilm.studies.tasks.physics_limits import with_limit_forces

MAP_POINTS_PER_FACTOR = 31
"""Lines of the sensitivity's map along each factor."""
MAX_NAMED_POINTS = 5
"""Points that a note names."""


class FittedSpace:
    """A fitted model in the space of a study: derivatives at points for all parameter vectors.

    thetas, shape (K, p): the fit first, then the ends of the parameters' ranges. grid are
    candidates for points, each scene once; everywhere all combinations of factors, with which no
    plan can be better than the best design.

    Raises InputError for a model without parameters, and where it cannot be used on the points of
    forces, to which it was fitted, or these do not bound the parameters.
    """

    def __init__(self, fit: FittedModel, config: Study, *, forces: pd.DataFrame) -> None:
        self.model, self.config = fit.force_model, config
        factors = factors_of_table(with_limit_forces(self.model, forces, config))
        check_columns_known(self.model, factors)
        if not fit.theta:
            raise InputError(f"the model {fit.model} has no parameters; nothing is to be designed")
        force_n = forces["force_n"].to_numpy()
        theta = local_fit_theta(self.model, factors, force_n, np.array(fit.theta))
        ranges = parameter_ranges(self.model, factors, force_n, theta)
        lower = [parameter.theta_lower for parameter in ranges if np.isfinite(parameter.lower)]
        upper = [parameter.theta_upper for parameter in ranges if np.isfinite(parameter.upper)]
        self.thetas = np.array([theta, *lower, *upper])
        self.space = space_of_study(config, centred=self.model.is_for_centred_pad)
        self.coordinates = coordinate_function("scene", self.space)
        most = config.optimal.candidates
        self.grid = self.space.grid(most, distinct=True)
        self.everywhere = self.space.grid(most, distinct=False)

    def derivatives(self, points: np.ndarray, *, every: bool = False) -> np.ndarray:
        """dη/dθ at points for the fit, or for every parameter vector, shape (K, n, p)."""
        named = dict(zip(self.space.names, points.T, strict=True))
        factors = Factors.of(**named)
        if self.model.column_names:
            table = plan_table(pd.DataFrame(named), position=self.space.position_columns)
            factors = factors_of_table(with_limit_forces(self.model, table, self.config))
        thetas = self.thetas if every else self.thetas[:1]
        return np.array([self.model.gradient(theta, factors) for theta in thetas])

    def outside_mask(self, points: np.ndarray) -> np.ndarray:
        """Mask of the points, shape (n, k), that lie outside the ranges, shape (n,)."""
        return np.any(np.abs(self.space.to_unit(points) - 0.5) > 0.5 + RANGE_TOLERANCE, axis=1)


def designs_by_name(
    fitted: FittedSpace, settings: OptimalDesigns, *, existing: pd.DataFrame | None
) -> dict[str, ContinuousDesign]:
    """All designs by name, the local one first: local, bayesian, maximin, exact-N, augmented.

    settings is the section ``optimal`` of a study, existing a table of scenes to add to: they are
    the first of the augmented design. An exact design with fewer points than the model has
    parameters determines none of them, and is not among the designs.
    """
    derivatives, parameters = fitted.derivatives(fitted.grid), fitted.thetas.shape[1]
    apart: dict[str, Any] = {
        "coordinates": fitted.coordinates(fitted.grid),
        "separation": settings.separation,
        "seed": settings.seed,
    }

    def exact_design(count: int) -> ContinuousDesign:
        chosen = exact_design_by_exchange(derivatives, count, **apart)
        return _design_sorted_by_points(_equal_weight_design(fitted.grid[chosen]))

    def augmented_design(existing: pd.DataFrame) -> ContinuousDesign:
        there = points_of_table(existing, fitted.space)
        added = exact_design_by_exchange(
            derivatives,
            parameters,
            existing=fitted.derivatives(there),
            existing_coordinates=fitted.coordinates(there),
            **apart,
        )
        return _equal_weight_design(np.concatenate([there, fitted.grid[added]]))

    searches: dict[str, Callable[[], ContinuousDesign]] = {
        "local": partial(_optimal_design_in_space, fitted, fitted.derivatives),
        "bayesian": partial(
            _optimal_design_in_space, fitted, partial(fitted.derivatives, every=True)
        ),
        "maximin": partial(_maximin_design, fitted),
    }
    for count in settings.points:
        if count >= parameters:
            searches[f"exact-{count}"] = partial(exact_design, count)
    if existing is not None:
        searches["augmented"] = partial(augmented_design, existing)
    designs = {}
    with track_progress(len(searches), unit="design", name=fitted.model.name) as bar:
        for name, search in searches.items():
            bar.current_step = name
            designs[name] = search()
            bar.update(1)
    return designs


def _optimal_design_in_space(fitted: FittedSpace, gradients: GradientFunction) -> ContinuousDesign:
    """The best weights on the grid; and off it, where derivatives cost no physics and the whole
    space can be simulated.
    """
    if not fitted.model.column_names and fitted.space.allowed_mask(fitted.space.levels(2)).all():
        design = optimal_design_in_space(gradients, fitted.space, fitted.everywhere, gap=1e-8)
    else:
        design = optimal_approximate_design(gradients(fitted.everywhere)).on(fitted.everywhere)
    return _design_sorted_by_points(design)


def _maximin_design(fitted: FittedSpace) -> ContinuousDesign:
    design = maximin_design(fitted.derivatives(fitted.everywhere, every=True))
    return _design_sorted_by_points(design.on(fitted.everywhere))


def _equal_weight_design(points: np.ndarray) -> ContinuousDesign:
    return ContinuousDesign(points, np.full(len(points), 1 / len(points)))


def _design_sorted_by_points(design: ContinuousDesign) -> ContinuousDesign:
    order = np.lexsort(np.round(design.points, 12).T[::-1])
    return replace(design, points=design.points[order], weights=design.weights[order])


def _design_table(
    fitted: FittedSpace, name: str, design: ContinuousDesign, existing: pd.DataFrame | None
) -> pd.DataFrame:
    table = table_of_points(design.points, fitted.space)
    table["point_id"] = [f"{name}-{number}" for number in table["point_id"]]
    table = table.assign(design=name, weight=design.weights, origin="design")
    if name == "augmented" and existing is not None:
        table["origin"] = np.where(table.index < len(existing), "existing", "added")
    return table


def efficiency_table(
    fitted: FittedSpace, designs: Mapping[str, ContinuousDesign], others: Mapping[str, np.ndarray]
) -> pd.DataFrame:
    """Every design and plan: D-efficiency for the fit, a bound of it, and over all vectors.

    The efficiency is that of the best design within the ranges: points outside can exceed one. The
    lower bound does not need the best design; others are points by the names of their plans.
    """
    candidates, local = fitted.derivatives(fitted.everywhere, every=True), designs["local"]
    best = np.array([optimal_approximate_design(layer).log_det[0] for layer in candidates])
    # Off the grid the best design may be a little better than on it.
    own = fitted.derivatives(local.points)[0]
    best[0] = max(best[0], *log_determinant(own, local.weights))
    reference = np.concatenate([candidates[0], own])
    rows = []
    plans = {**designs, **{name: _equal_weight_design(points) for name, points in others.items()}}
    for name, design in plans.items():
        points, weights = design.points, design.weights
        derivatives = fitted.derivatives(points, every=True)
        logs = log_determinant(derivatives, weights)
        efficiency = np.exp((logs - best) / fitted.thetas.shape[1])
        if not fitted.outside_mask(points).any():
            efficiency = np.minimum(efficiency, 1.0)  # the grid is a little worse than the space
        level = sensitivity(derivatives[0], reference, weights=weights)
        by_local = float(efficiency[0]) * (local.efficiency_bound or 0.0)
        rows.append(
            {
                "plan": name,
                "points": len(points),
                "scenes": len(np.unique(np.round(fitted.coordinates(points), 9), axis=0)),
                "d_efficiency": float(efficiency[0]),
                "d_efficiency_lower": max(1 / max(float(level.max()), 1.0), by_local),
                "d_efficiency_min": float(efficiency.min()),
                "d_efficiency_mean": float(np.mean(efficiency)),
            }
        )
    return pd.DataFrame(rows)


def _design_notes(
    fitted: FittedSpace, sizes: Sequence[int], existing: pd.DataFrame | None
) -> list[str]:
    """Reasons for designs that are missing, and for efficiencies above one."""
    parameters, notes = fitted.thetas.shape[1], []
    for size in sizes:
        if size < parameters:
            notes.append(
                f"optimal.points: no design exact-{size}: {size} points do not determine the "
                f"{parameters} parameters of {fitted.model.name}; give {parameters} or more"
            )
    if existing is not None:
        outside = fitted.outside_mask(points_of_table(existing, fitted.space))
        points = existing.loc[outside, "point_id"].tolist()
        if points:
            ids = ", ".join(points[:MAX_NAMED_POINTS]) + ", …" * (len(points) > MAX_NAMED_POINTS)
            limits = fitted.space.limits.items()
            ranges = ", ".join(f"{name} {low:.4g} … {high:.4g}" for name, (low, high) in limits)
            notes.append(
                f"augmented: {len(points)} of {len(existing)} existing points lie outside the "
                f"study's ranges ({ranges}): {ids}; the D-efficiency is relative to the best "
                "design within the ranges and can exceed 1"
            )
    return notes


def sensitivity_map(fitted: FittedSpace, local: ContinuousDesign) -> pd.DataFrame:
    """The local design's sensitivity over the space in two panels, and its points.

    Over gap and amplitude it is the largest over positions; over the position that of the smallest
    gap and the largest amplitude.
    """
    space, own = fitted.space, fitted.derivatives(local.points)
    layers = {"design": local.points}
    lines = np.linspace(0, 1, MAP_POINTS_PER_FACTOR)
    gaps = np.stack(np.meshgrid(lines, lines, indexing="ij"), axis=-1).reshape(-1, 2)
    if len(space.names) == 2:
        layers["gap"] = space.from_unit(gaps)
    else:
        ends = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0]]
        if space.names[2:] == CARTESIAN_COLUMNS:
            ends = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [0.0, 1.0], [1.0, 1.0]]
        everywhere = np.repeat(gaps, len(ends), axis=0), np.tile(ends, (len(gaps), 1))
        layers["gap"] = space.from_unit(np.hstack(everywhere))
        narrow = np.tile([0.0, 1.0], (len(gaps), 1))
        layers["position"] = space.from_unit(np.column_stack([narrow, gaps]))
    parts = []
    for layer, points in layers.items():
        points = points[space.allowed_mask(points)]
        level = sensitivity(own, fitted.derivatives(points), weights=local.weights)
        at = factors_of_table(table_of_points(points, space))
        micrometres = {"h0_um": 1e6 * at.h0_m, "hv_um": 1e6 * at.hv_m}
        position_mm = {"x_mm": 1e3 * at.x_m, "y_mm": 1e3 * at.y_m}
        part = pd.DataFrame({"layer": layer, **micrometres, **position_mm}).round(9)
        part["sensitivity"] = level
        if layer == "design":
            part["weight"] = local.weights
        else:
            # A panel shows the largest value over what it does not show.
            seen = ["layer", *(micrometres if layer == "gap" else position_mm)]
            part = part.groupby(seen)[["sensitivity"]].max().reset_index()
        parts.append(part)
    return pd.concat(parts, ignore_index=True)


def designs_of_fit(
    fit: FittedModel,
    config: Study,
    *,
    forces: pd.DataFrame,
    existing: pd.DataFrame | None = None,
    plans: Mapping[str, pd.DataFrame] | None = None,
    patterns: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """All optimal designs of a fit, with its plans and patterns beside them.

    Args:
        forces: what the model was fitted to.
        existing: scenes that a design adds to.
        plans: scenes of other plans, by their names.
        patterns: summary of the searches by the paper's criterion.

    Returns: tables ``designs``, their points, ``efficiencies`` beside other plans, and
        ``sensitivity``, a map; and a ``summary``.

    Raises InputError where the model cannot be used on these points, or has no parameters.
    """
    fitted = FittedSpace(fit, config, forces=forces)
    others = {name: points_of_table(scenes, fitted.space) for name, scenes in (plans or {}).items()}
    for kind in ("scalings", "forms"):
        for search, patterns_found in (patterns or {}).get(kind, {}).items():
            for pattern in patterns_found:
                table = pd.DataFrame(pattern["points"])[list(fitted.space.names)]
                others[f"pattern {pattern['pattern']} ({search})"] = table.to_numpy()
    designs = designs_by_name(fitted, config.optimal, existing=existing)
    table = efficiency_table(fitted, designs, others)
    bounds = {name: design.efficiency_bound for name, design in designs.items()}
    summary = {
        "model": fitted.model.name,
        "theta": fitted.thetas[0].tolist(),
        "certificates": {name: bound for name, bound in bounds.items() if bound is not None},
        "notes": _design_notes(fitted, config.optimal.points, existing),
    }
    points = [_design_table(fitted, *named_design, existing) for named_design in designs.items()]
    return {
        "designs": pd.concat(points, ignore_index=True),
        "efficiencies": table,
        "sensitivity": sensitivity_map(fitted, designs["local"]),
        "summary": summary,
    }
