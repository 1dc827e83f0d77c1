"""D-optimal designs with a certificate, and how good other plans are beside them.

  squeezefilm optimal FIT.json --forces FORCES.csv --limits LIMITS.csv --config C.yaml \\
      --plans NAME=SCENES.csv … --patterns DESIGN.json --existing SCENES.csv \\
      --output DESIGNS.csv --efficiencies PLANS.csv --sensitivity MAP.csv --summary SUMMARY.json

The model is FIT.json's, FORCES.csv what it was fitted to: they give the parameters, and how far
these can go. DESIGNS.csv has these designs, all certified by the equivalence theorem:

  local      the best weights of points anywhere in the space, for the fitted parameters
  bayesian   for the mean over the parameter vectors at the ends of the parameters' ranges
  maximin    for the worst of these vectors
  exact-N    the best N points, each once and apart from the others
  augmented  the points of --existing and the best ones to add to them

PLANS.csv has the D-efficiency of these and of every plan given, with a lower bound that does not
need the best design; MAP.csv is what the figure `sensitivity` is drawn from.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.cli.steps.limits import with_limits
from squeezefilm.designs.box import corners
from squeezefilm.designs.continuous_design import ContinuousDesign, optimal_in_box, sensitivity
from squeezefilm.designs.exact_design import exchange
from squeezefilm.designs.optimal_design import maximin_design, optimal_weights
from squeezefilm.io.errors import InputError
from squeezefilm.io.sources import parse_sources
from squeezefilm.io.tables import (
    SCENE_COLUMNS,
    read_json,
    read_ok_forces,
    read_scenes,
    scene_points,
    write_json,
    write_table,
)
from squeezefilm.models.experiments import check_columns, factors_of
from squeezefilm.models.fitted import FittedModel, read_fit
from squeezefilm.models.force_model import COLUMNS, ExpressionModel, Factors
from squeezefilm.models.local_fit import local_fit
from squeezefilm.models.profile_likelihood import ParameterRange, parameter_ranges
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.space import Space
from squeezefilm.studies.study import scene_of

SECTIONS = ("gas", "actuator", "finger", "screen", "positions", "optimal")
MAP_LINES = 31
"""Lines of the sensitivity's map along each factor."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument(
        "--forces", required=True, metavar="FORCES.csv", help="what it was fitted to"
    )
    parser.add_argument("--limits", metavar="LIMITS.csv", help="physics limits of the same scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--plans", nargs="*", default=[], metavar="NAME=SCENES.csv")
    parser.add_argument(
        "--patterns", metavar="DESIGN.json", help="patterns of `squeezefilm design`"
    )
    parser.add_argument("--existing", metavar="SCENES.csv", help="points to add to")
    parser.add_argument("--output", required=True, metavar="DESIGNS.csv", help="designs to write")
    parser.add_argument("--efficiencies", required=True, metavar="PLANS.csv", help="table to write")
    parser.add_argument("--sensitivity", required=True, metavar="MAP.csv", help="figure's table")
    parser.add_argument("--summary", required=True, metavar="SUMMARY.json", help="certificates")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config).only(SECTIONS)
    fit = read_fit(options.fit)
    names = [word.partition("=")[0] for word in options.plans]
    plans = parse_sources(options.plans, names=names, user="optimal")
    try:
        study = _Study.of(fit, options, config)
        others = {name: study.space.points(read_scenes(path)) for name, path in plans.items()}
        if options.patterns:
            others |= _patterns(options.patterns, study.space.box.names)
        designs = _designs(study, config["optimal"], existing=options.existing)
    except InputError as error:
        raise InputError(f"{options.fit}: {error}") from None
    table = _efficiencies(study, designs, others)
    write_table(pd.concat([each.table for each in designs], ignore_index=True), options.output)
    write_table(table, options.efficiencies)
    write_table(_map(study, designs[0]), options.sensitivity)
    write_json(_summary(study, designs, table), options.summary)
    print(table[["plan", "points", "d_efficiency", "lower_bound"]].to_string(index=False))


@dataclass(frozen=True, eq=False)
class _Study:
    """A fitted model in its space: derivatives at points for all parameter vectors.

    thetas, shape (K, p): the fit first, then the ends of the parameters' ranges. grid are
    candidates for points, each scene once; everywhere all combinations of factors, with which no
    plan can be better than the best design.
    """

    model: ExpressionModel
    config: Config
    space: Space
    ranges: list[ParameterRange]
    thetas: np.ndarray
    grid: np.ndarray
    everywhere: np.ndarray

    @classmethod
    def of(cls, fit: FittedModel, options: argparse.Namespace, config: Config) -> _Study:
        model = fit.force_model
        if not fit.theta:
            raise InputError(f"the model {model.name} has no parameters; nothing is to be designed")
        forces = read_ok_forces(options.forces)
        factors = factors_of(forces, limits=options.limits)
        check_columns(model, factors)
        force_n = forces["force_n"].to_numpy()
        theta = local_fit(model, factors, force_n, np.array(fit.theta))
        ranges = parameter_ranges(model, factors, force_n, theta)
        ends = [
            each
            for one in ranges
            for each, end in ((one.theta_lower, one.lower), (one.theta_upper, one.upper))
            if np.isfinite(end)
        ]
        space = Space.of(config, centred=model.is_centred)
        most = config["optimal"]["candidates"]
        return cls(
            model=model,
            config=config,
            space=space,
            ranges=ranges,
            thetas=np.array([theta, *ends]),
            grid=space.grid(most, distinct=True),
            everywhere=space.grid(most, distinct=False),
        )

    def derivatives(self, points: np.ndarray, *, layers: slice = slice(0, 1)) -> np.ndarray:
        """dη/dθ at points for some of the parameter vectors, shape (K, n, p)."""
        columns: dict[str, np.ndarray] = {}
        if self.model.column_names:
            table = self.space.table(points)
            scenes = [scene_of(point, self.config) for point in scene_points(table)]
            known = with_limits(table, scenes)
            columns = {name: known[name].to_numpy() for name in COLUMNS.values()}
        factors = Factors.of(**dict(zip(self.space.box.names, points.T, strict=True)), **columns)
        return np.array([self.model.gradient(theta, factors) for theta in self.thetas[layers]])


@dataclass(frozen=True, eq=False)
class _Design:
    """A design: its points, their weights, and the two as a table.

    certificate is a lower bound of its criterion's efficiency against all designs, where the
    equivalence theorem gives one.
    """

    name: str
    points: np.ndarray
    weights: np.ndarray
    table: pd.DataFrame
    certificate: float | None = None


def _designs(study: _Study, settings: dict[str, Any], *, existing: str | None) -> list[_Design]:
    """All designs, the local one first."""
    every = slice(0, None)
    local = _anywhere(study, slice(0, 1))
    bayesian = _anywhere(study, every)
    weights, _ = maximin_design(study.derivatives(study.everywhere, layers=every))
    used = weights.support
    designs = [
        _design(study, "local", local.points, local.weights, local.efficiency_bound),
        _design(study, "bayesian", bayesian.points, bayesian.weights, bayesian.efficiency_bound),
        _design(
            study,
            "maximin",
            study.everywhere[used],
            weights.weights[used],
            weights.efficiency_bound,
        ),
    ]
    derivatives = study.derivatives(study.grid)
    places = study.space.coordinates(study.grid)
    apart = {"coordinates": places, "separation": settings["separation"], "seed": settings["seed"]}
    parameters = study.thetas.shape[1]
    for count in settings["points"]:
        if count < parameters:
            continue
        found = exchange(derivatives, count, **apart)
        points = study.grid[found.chosen]
        designs.append(_design(study, f"exact-{count}", points, np.full(count, 1 / count)))
    if existing is not None:
        there = study.space.points(read_scenes(existing))
        found = exchange(
            derivatives,
            parameters,
            existing=study.derivatives(there),
            existing_coordinates=study.space.coordinates(there),
            **apart,
        )
        points = np.concatenate([there, study.grid[found.chosen]])
        origins = ["existing"] * len(there) + ["added"] * parameters
        share = np.full(len(points), 1 / len(points))
        designs.append(_design(study, "augmented", points, share, origins=origins))
    return designs


def _anywhere(study: _Study, layers: slice) -> ContinuousDesign:
    """The best weights on the grid; and off it, where derivatives cost no physics and the whole
    box can be simulated.
    """

    def gradients(points: np.ndarray) -> np.ndarray:
        return study.derivatives(points, layers=layers)

    if not study.model.column_names and study.space.allowed(corners(study.space.box)).all():
        return optimal_in_box(gradients, study.space.box, study.everywhere, gap=1e-8)
    derivatives = gradients(study.everywhere)
    found = optimal_weights(derivatives)
    used = found.support
    return ContinuousDesign(
        points=study.everywhere[used],
        weights=found.weights[used] / found.weights[used].sum(),
        derivatives=derivatives[:, used],
        prior=np.full(len(derivatives), 1 / len(derivatives)),
        efficiency_bound=found.efficiency_bound,
    )


def _design(
    study: _Study,
    name: str,
    points: np.ndarray,
    weights: np.ndarray,
    certificate: float | None = None,
    *,
    origins: list[str] | None = None,
) -> _Design:
    order = np.arange(len(points)) if origins else np.lexsort(np.round(points, 12).T[::-1])
    points, weights = points[order], weights[order]
    table = study.space.table(points)[list(SCENE_COLUMNS)]
    table["point_id"] = [f"{name}-{number}" for number in table["point_id"]]
    table = table.assign(design=name, weight=weights, origin=origins or "design")
    return _Design(name, points, weights, table, certificate)


def _patterns(path: str, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """The patterns that `squeezefilm design` found, by the search they come from."""
    values = read_json(path)
    found = {}
    for kind in ("scalings", "forms"):
        for search, patterns in values.get(kind, {}).items():
            for pattern in patterns:
                points = [[point[name] for name in names] for point in pattern["points"]]
                found[f"pattern {pattern['pattern']} ({search})"] = np.array(points)
    if not found:
        raise InputError(f"{path}: no patterns; give what `squeezefilm design` wrote")
    return found


def _efficiencies(
    study: _Study, designs: list[_Design], others: dict[str, np.ndarray]
) -> pd.DataFrame:
    """Every design and plan: D-efficiency for the fit, its bounds, and over all vectors."""
    every = slice(0, None)
    candidates = study.derivatives(study.everywhere, layers=every)
    best = np.array([optimal_weights(layer).log_det[0] for layer in candidates])
    # Off the grid the best design may be a little better than on it.
    local = designs[0]
    rows = []
    own = study.derivatives(local.points)[0]
    reference = max(best[0], _log_det(own, local.weights))
    reference_points = np.concatenate([candidates[0], own])
    plans = {design.name: (design.points, design.weights) for design in designs}
    for name, points in others.items():
        plans[name] = (points, np.full(len(points), 1 / len(points)))
    for name, (points, weights) in plans.items():
        derivatives = study.derivatives(points, layers=every)
        logs = np.array([_log_det(layer, weights) for layer in derivatives])
        efficiency = np.exp((logs - [reference, *best[1:]]) / study.thetas.shape[1])
        bound, highest = 0.0, np.inf
        if np.isfinite(logs[0]):
            level = sensitivity(derivatives[0], reference_points, weights=weights)
            highest = float(max(level.max(), 1.0))
            bound = 1 / highest
        certificate = local.certificate or 0.0
        rows.append(
            {
                "plan": name,
                "points": len(points),
                "scenes": len(np.unique(np.round(study.space.coordinates(points), 9), axis=0)),
                "d_efficiency": min(float(efficiency[0]), 1.0),
                "lower_bound": max(bound, min(float(efficiency[0]), 1.0) * certificate),
                "lower_bound_alone": bound,
                "largest_sensitivity": highest,
                "least_over_ranges": min(float(efficiency.min()), 1.0),
                "mean_over_ranges": min(float(np.mean(efficiency)), 1.0),
            }
        )
    return pd.DataFrame(rows)


def _log_det(derivatives: np.ndarray, weights: np.ndarray) -> float:
    """log det of the information per point; minus infinity where it is singular."""
    f = np.sqrt(weights)[:, None] * derivatives
    size = np.linalg.norm(f, axis=0)
    if len(f) < f.shape[1] or not np.all(np.isfinite(size) & (size > 0)):
        return -np.inf
    diagonal = np.abs(np.diagonal(np.linalg.qr(f / size, mode="r")))
    if diagonal.min() < 1e-12:
        return -np.inf
    return float(2 * np.sum(np.log(diagonal * size)))


def _map(study: _Study, local: _Design) -> pd.DataFrame:
    """The local design's sensitivity over the space in two panels, and its points."""
    box = study.space.box
    own = study.derivatives(local.points)
    layers = {"design": local.points}
    lines = np.linspace(0, 1, MAP_LINES)
    gaps = np.stack(np.meshgrid(lines, lines, indexing="ij"), axis=-1).reshape(-1, 2)
    if len(box.names) == 2:
        layers["gap"] = box.from_unit(gaps)
    else:
        ends = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0]]
        layers["gap"] = box.from_unit(
            np.concatenate([np.column_stack([gaps, np.tile(end, (len(gaps), 1))]) for end in ends])
        )
        narrow = np.tile([0.0, 1.0], (len(gaps), 1))
        layers["position"] = box.from_unit(np.column_stack([narrow, gaps]))
    parts = []
    for layer, points in layers.items():
        points = points[study.space.allowed(points)]
        level = sensitivity(own, study.derivatives(points), weights=local.weights)
        scenes = study.space.table(points)
        radius_mm, angle = 1e3 * scenes["phi_r_m"], np.radians(scenes["phi_deg"])
        part = pd.DataFrame(
            {
                "layer": layer,
                "h0_um": np.round(1e6 * scenes["h0_m"], 9),
                "hv_um": np.round(1e6 * scenes["hv_m"], 9),
                "x_mm": np.round(radius_mm * np.cos(angle), 9),
                "y_mm": np.round(radius_mm * np.sin(angle), 9),
                "sensitivity": level,
            }
        )
        if layer == "design":
            part["weight"] = local.weights
        else:
            # A panel shows the largest value over what it does not show.
            seen = ["layer", *(["h0_um", "hv_um"] if layer == "gap" else ["x_mm", "y_mm"])]
            part = part.groupby(seen)[["sensitivity"]].max().reset_index()
        parts.append(part)
    note = (
        f"Model {study.model.name}: sensitivity d(x)/p of the locally D-optimal design, nowhere "
        "above one and one at its points (circles, their area the weight), as the equivalence "
        f"theorem asks; D-efficiency at least {np.floor(1e6 * (local.certificate or 0)) / 1e6:.6f}."
    )
    if "position" in layers:
        note += " Left: largest over positions; right: smallest gap, largest amplitude."
    return pd.concat(parts, ignore_index=True).assign(note=note)


def _summary(study: _Study, designs: list[_Design], table: pd.DataFrame) -> dict[str, Any]:
    return {
        "model": study.model.name,
        "theta": [float(value) for value in study.thetas[0]],
        "parameter_vectors": len(study.thetas),
        "candidates": len(study.everywhere),
        "scenes_among_them": len(study.grid),
        "certificates": {
            design.name: design.certificate for design in designs if design.certificate is not None
        },
        "d_efficiency": dict(zip(table["plan"], map(float, table["d_efficiency"]), strict=True)),
        "lower_bound": dict(zip(table["plan"], map(float, table["lower_bound"]), strict=True)),
        "parameter_ranges": [
            {
                "name": each.name,
                "unit": each.unit,
                "estimate": each.estimate,
                "lower": each.lower if np.isfinite(each.lower) else None,
                "upper": each.upper if np.isfinite(each.upper) else None,
            }
            for each in study.ranges
        ],
    }
