"""Find the points at which simulations teach most about a fitted model: D-optimal designs.

  squeezefilm design two-factor FIT.json --config C.yaml \\
      --output DESIGN.csv --searches SEARCHES.csv --summary DESIGN.json
  squeezefilm design four-factor FIT.json --config C.yaml \\
      --output DESIGN.csv --distinct DISTINCT.csv --searches SEARCHES.csv --summary DESIGN.json

Two factors: triplets by criterion (12), searched in each scaling of the distances; the patterns
found with the study's own scaling are united and extended to the wanted number of points. Four
factors: the determinant alone (DESIGN.csv), and once more with the points physically distinct
(DISTINCT.csv). SEARCHES.csv has every point of every search, DESIGN.json the patterns and their
efficiency against an optimum found by exchange on a fine grid.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.designs.box import Box, coordinates, corners
from squeezefilm.designs.paper_design import (
    Criterion,
    Design,
    d_efficiency,
    exchange_design,
    search_design,
)
from squeezefilm.designs.patterns import Pattern, augment, find_patterns, find_regions
from squeezefilm.io.errors import InputError
from squeezefilm.io.parallel import parallel_map
from squeezefilm.io.tables import DESIGN_COLUMNS, write_json, write_table
from squeezefilm.models.fitted import read_fit
from squeezefilm.models.force_model import ExpressionModel, get_model
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.plans import factor_ranges, plan

SECTIONS = {
    "two-factor": ("design", "screen"),
    "four-factor": ("four_factor_design", "positions", "screen", "actuator", "finger"),
}
TWO_FACTOR_SCALINGS = ("unit", "micrometre", "metre")
FINE_LEVELS = {"two-factor": 181, "four-factor": 7}
"""Levels per factor of the grid on which the optimum to compare with is sought."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", choices=SECTIONS, help=" or ".join(SECTIONS), metavar="MODEL")
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="DESIGN.csv", help="the design")
    parser.add_argument("--distinct", metavar="DISTINCT.csv", help="the one of distinct scenes")
    parser.add_argument("--processes", type=int, default=1, help="to spread the searches over")
    parser.add_argument("--searches", required=True, metavar="SEARCHES.csv", help="all searches")
    parser.add_argument("--summary", required=True, metavar="DESIGN.json", help="what was found")


def run(options: argparse.Namespace) -> None:
    if (options.distinct is not None) != (options.model == "four-factor"):
        raise InputError("--distinct belongs to the four-factor design, and to no other")
    config = load_config(options.config).only(SECTIONS[options.model])
    fit = read_fit(options.fit)
    if fit.model != options.model.replace("-", "_"):
        raise InputError(f"{options.fit}: a fit of the model {fit.model}, not of {options.model}")
    model = get_model(fit.model)
    design = _two_factor if options.model == "two-factor" else _four_factor
    try:
        tables, searches, summary = design(
            model, np.array(fit.theta), config, processes=options.processes
        )
    except InputError as error:
        raise InputError(f"{options.fit}: {error}") from None
    for path, table in zip((options.output, options.distinct), tables, strict=False):
        write_table(table, path)
    write_table(searches, options.searches)
    write_json(summary, options.summary)


Found = tuple[list[pd.DataFrame], pd.DataFrame, dict[str, Any]]


def _two_factor(
    model: ExpressionModel, theta: np.ndarray, config: Config, *, processes: int
) -> Found:
    settings, box = config["design"], Box(*_limits(config, model.factor_names))
    determinant = Criterion(_gradient(model, theta), box)
    best = exchange_design(determinant, 3, levels=FINE_LEVELS["two-factor"])
    rows, summary = [], {}
    for scaling in TWO_FACTOR_SCALINGS:
        criterion = Criterion(determinant.gradient, box, distance=coordinates(scaling, box))
        designs = _searches(criterion, 3, settings, processes=processes)
        patterns = find_patterns(designs, box)
        rows += _search_rows(scaling, designs, patterns, box, model)
        summary[scaling] = _pattern_summaries(patterns, determinant, best, model)
        if scaling == settings["scaling"]:
            regions = augment(
                criterion, find_regions(patterns, box), settings["points"], candidates=corners(box)
            )
    table = _design_table(
        [region.point for region in regions], [region.origin for region in regions], model
    )
    about = {
        "scaling": settings["scaling"],
        "searches": settings["searches"],
        "scalings": summary,
        "d_efficiency": d_efficiency(
            determinant.derivatives(np.array([region.point for region in regions])),
            determinant.derivatives(best.points),
        ),
    }
    return [table], pd.DataFrame(rows), about


def _four_factor(
    model: ExpressionModel, theta: np.ndarray, config: Config, *, processes: int
) -> Found:
    settings, box = config["four_factor_design"], Box(*_limits(config, model.factor_names))
    gradient = _gradient(model, theta)
    forms = {
        "paper": Criterion(gradient, box),
        "distinct": Criterion(
            gradient, box, apart=coordinates("scene", box), separation=settings["separation"]
        ),
    }
    tables, rows, summary = [], [], {}
    for form, criterion in forms.items():
        points = len(model.parameter_names)
        best = exchange_design(criterion, points, levels=FINE_LEVELS["four-factor"])
        designs = _searches(criterion, points, settings, processes=processes)
        patterns = find_patterns(designs, box)
        rows += _search_rows(form, designs, patterns, box, model)
        summary[form] = _pattern_summaries(patterns, criterion, best, model)
        tables.append(_design_table(patterns[0].design.points, [form] * points, model))
    return tables, pd.DataFrame(rows), {"searches": settings["searches"], "forms": summary}


def _limits(
    config: Config, names: Sequence[str]
) -> tuple[tuple[str, ...], tuple[float, ...], tuple[float, ...]]:
    """The factors' names, and the lower and upper limits of the experimental space."""
    if "phi_r_m" in names:
        limits = factor_ranges(config)
    else:
        screen = config["screen"]
        limits = {name: (screen[name]["start"], screen[name]["stop"]) for name in names}
    lower, upper = zip(*(limits[name] for name in names), strict=True)
    return tuple(names), lower, upper


def _gradient(model: ExpressionModel, theta: np.ndarray) -> Any:
    return lambda points: model.gradient(theta, model.factors(points))


def _searches(
    criterion: Criterion, points: int, settings: dict[str, Any], *, processes: int
) -> list[Design]:
    seeds = range(settings["first_seed"], settings["first_seed"] + settings["searches"])
    return parallel_map(
        lambda seed: search_design(criterion, points, seed=seed), seeds, processes=processes
    )


def _search_rows(
    scaling: str,
    designs: Sequence[Design],
    patterns: Sequence[Pattern],
    box: Box,
    model: ExpressionModel,
) -> list[dict[str, Any]]:
    """One row for each point of each search, with the pattern that the search ended in."""
    rows = []
    for search, design in enumerate(designs, start=1):
        name = next(
            pattern.name
            for pattern in patterns
            if len(find_patterns([pattern.design, design], box)) == 1
        )
        for point in design.points:
            about = {"scaling": scaling, "search": search, "pattern": name}
            rows.append({**about, **_named(point, model), "objective": design.value})
    return rows


def _pattern_summaries(
    patterns: Sequence[Pattern], criterion: Criterion, best: Design, model: ExpressionModel
) -> list[dict[str, Any]]:
    return [
        {
            "pattern": pattern.name,
            "count": pattern.count,
            "objective": pattern.design.value,
            "objective_excess": pattern.excess,
            "inverse_determinant": pattern.design.inverse_determinant,
            "d_efficiency": d_efficiency(
                criterion.derivatives(pattern.design.points), criterion.derivatives(best.points)
            ),
            "points": [_named(point, model) for point in pattern.design.points],
        }
        for pattern in patterns
    ]


def _named(point: Iterable[float], model: ExpressionModel) -> dict[str, float]:
    """A point with its factors' names; twelve digits, so that a limit reads 2e-06."""
    return {
        name: float(f"{value:.12g}") for name, value in zip(model.factor_names, point, strict=True)
    }


def _design_table(
    points: Iterable[Iterable[float]], origins: Sequence[str], model: ExpressionModel
) -> pd.DataFrame:
    factors = pd.DataFrame([_named(point, model) for point in points])
    scenes = plan(**{name: factors[name].to_numpy() for name in model.factor_names})
    return scenes.assign(origin=origins)[list(DESIGN_COLUMNS)]
