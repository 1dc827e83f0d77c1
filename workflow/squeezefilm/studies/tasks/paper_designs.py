"""The paper's designs for a study: optimal triplets, and five points with four factors.

Two factors: triplets by criterion (12), searched in each scaling of the distances; the patterns
found with the study's own scaling are united and extended to the wanted number of points. Four
factors: the determinant alone, and once more with the points physically distinct.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.config.loading import Config
from squeezefilm.designs.box import Box, coordinates
from squeezefilm.designs.paper_design import (
    Criterion,
    Design,
    Gradient,
    Pattern,
    augment,
    d_efficiency,
    exchange_design,
    find_patterns,
    find_regions,
    search_design,
    spread_on_lines,
)
from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import FittedModel
from squeezefilm.models.force_model import ExpressionModel, get_model
from squeezefilm.parallel import parallel_map
from squeezefilm.studies.space import box_of, plan

DIGITS = 6
TWO_FACTOR_SCALINGS = ("unit", "micrometre", "metre")
TWO_FACTOR_LEVELS, FOUR_FACTOR_LEVELS = 181, 7
"""Levels per factor of the grid on which the optimum to compare with is sought."""


@dataclass(frozen=True, eq=False)
class PaperDesigns:
    """Designs as tables, every point of every search, and the patterns found, ready for JSON."""

    tables: list[pd.DataFrame]
    searches: pd.DataFrame
    summary: dict[str, Any]


def two_factor_designs(fit: FittedModel, config: Config, *, processes: int) -> PaperDesigns:
    model, theta = get_model(fit.model), _parameters(fit)
    settings, box = config["design"], box_of(config, centred=True)
    determinant = Criterion(_gradient(model, theta, box), box)
    best = exchange_design(determinant, 3, levels=TWO_FACTOR_LEVELS)
    rows, summary = [], {}
    for scaling in TWO_FACTOR_SCALINGS:
        criterion = Criterion(determinant.gradient, box, distance=coordinates(scaling, box))
        designs = _searches(criterion, 3, settings, processes=processes)
        patterns, each, summary[scaling] = _patterns(scaling, criterion, designs, best)
        rows += each
        if scaling == settings["scaling"]:
            regions = augment(criterion, find_regions(patterns, box), settings["points"])
    points = np.array([region.point for region in regions])
    table = _design_table(points, [region.origin for region in regions], box, fit.position)
    about = {
        "scaling": settings["scaling"],
        "searches": settings["searches"],
        "scalings": summary,
        "d_efficiency": d_efficiency(
            determinant.derivatives(points), determinant.derivatives(best.points)
        ),
    }
    return PaperDesigns([table], pd.DataFrame(rows), about)


def four_factor_designs(fit: FittedModel, config: Config, *, processes: int) -> PaperDesigns:
    model, theta = get_model(fit.model), _parameters(fit)
    settings, box = config["four_factor_design"], box_of(config)
    gradient = _gradient(model, theta, box)
    forms = {
        "paper": Criterion(gradient, box),
        "distinct": Criterion(
            gradient, box, apart=coordinates("scene", box), separation=settings["separation"]
        ),
    }
    tables, rows, summary = [], [], {}
    for form, criterion in forms.items():
        points = len(model.parameter_names)
        best = exchange_design(criterion, points, levels=FOUR_FACTOR_LEVELS)
        designs = [
            spread_on_lines(criterion, design, ratio=("h0_m", "hv_m"))
            for design in _searches(criterion, points, settings, processes=processes)
        ]
        patterns, each, summary[form] = _patterns(form, criterion, designs, best)
        rows += each
        tables.append(_design_table(patterns[0].design.points, [form] * points, box, box.names[2:]))
    about = {"searches": settings["searches"], "forms": summary}
    return PaperDesigns(tables, pd.DataFrame(rows), about)


def _parameters(fit: FittedModel) -> np.ndarray:
    """A fit's parameters to the digits that it has, shape (p,).

    A search ends at any of equally good points; of digits that are round-off, round-off chooses.
    """
    return np.array([float(f"{value:.{DIGITS}g}") for value in fit.theta])


def _gradient(model: ExpressionModel, theta: np.ndarray, box: Box) -> Gradient:
    return lambda points: model.gradient(
        theta, Factors.of(**dict(zip(box.names, points.T, strict=True)))
    )


def _searches(
    criterion: Criterion, points: int, settings: dict[str, Any], *, processes: int
) -> list[Design]:
    seeds = range(settings["first_seed"], settings["first_seed"] + settings["searches"])
    return parallel_map(
        lambda seed: search_design(criterion, points, seed=seed), seeds, processes=processes
    )


def _patterns(
    name: str, criterion: Criterion, designs: Sequence[Design], best: Design
) -> tuple[list[Pattern], list[dict[str, Any]], list[dict[str, Any]]]:
    """The patterns that searches ended in, a row for each point of each, and what patterns are."""
    box, optimal = criterion.box, criterion.derivatives(best.points)
    patterns = find_patterns(designs, box)
    names = {index: pattern.name for pattern in patterns for index in pattern.members}
    rows = [
        {
            "scaling": name,
            "search": index + 1,
            "pattern": names[index],
            **_named(point, box),
            "objective": design.value,
        }
        for index, design in enumerate(designs)
        for point in design.points
    ]
    summaries = [
        {
            "pattern": pattern.name,
            "count": len(pattern.members),
            "objective": pattern.design.value,
            "objective_excess": pattern.excess,
            "inverse_determinant": pattern.design.inverse_determinant,
            "d_efficiency": d_efficiency(criterion.derivatives(pattern.design.points), optimal),
            "points": [_named(point, box) for point in pattern.design.points],
        }
        for pattern in patterns
    ]
    return patterns, rows, summaries


def _named(point: Iterable[float], box: Box) -> dict[str, float]:
    """A point with its factors' names; twelve digits, so that a limit reads 2e-06."""
    return {name: float(f"{value:.12g}") for name, value in zip(box.names, point, strict=True)}


def _design_table(
    points: np.ndarray, origins: Sequence[str], box: Box, position: tuple[str, ...]
) -> pd.DataFrame:
    factors = pd.DataFrame([_named(point, box) for point in points])
    return plan(factors, position=position).assign(origin=origins)
