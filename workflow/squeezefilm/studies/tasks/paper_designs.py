"""The paper's designs for a study: optimal triplets, and five points with four factors.

Two factors: triplets by criterion (12), searched in each scaling of the distances; the patterns
found with the study's own scaling are united and extended to the wanted number of points. Four
factors: the determinant alone, and once more with the points physically distinct.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.config.study import Design, FourFactorDesign, Study
from squeezefilm.designs.paper_design import (
    Criterion,
    DesignPattern,
    add_corner_points,
    distinct_support_points,
    find_design_patterns,
    search_design,
    spread_along_ratio_lines,
)
from squeezefilm.designs.space import Space, coordinate_function
from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import FittedModel
from squeezefilm.models.force_model import get_model
from squeezefilm.parallel import parallel_map
from squeezefilm.studies.space import plan_table, round_to_twelve_digits, space_of_study

PARAMETER_DIGITS = 6
TWO_FACTOR_SCALINGS = ("unit", "micrometre", "metre")


PaperDesigns = dict[str, pd.DataFrame | dict[str, Any]]
"""Designs as tables, of two factors every point of every search, and the patterns, for JSON."""


def two_factor_designs(fit: FittedModel, config: Study, *, processes: int) -> PaperDesigns:
    settings, space = config.design, space_of_study(config, centred=True)
    determinant = _determinant_criterion(fit, space)
    searches, summary = [], {}
    for scaling in TWO_FACTOR_SCALINGS:
        criterion = replace(determinant, distance_coordinates=coordinate_function(scaling, space))
        patterns, table, summary[scaling] = _pattern_tables(
            scaling, criterion, len(fit.theta), settings, processes=processes
        )
        searches.append(table)
        if scaling == settings.scaling:
            regions = add_corner_points(
                criterion, distinct_support_points(patterns, space), settings.points
            )
    points = np.array([region.point for region in regions])
    design = plan_table(_factor_table(points, space), position=fit.position_columns)
    design["origin"] = [" and ".join(region.pattern_names) for region in regions]
    about = {"scaling": settings.scaling, "searches": settings.searches, "scalings": summary}
    search_table = pd.concat(searches, ignore_index=True)
    return {"design": design, "searches": search_table, "summary": about}


def four_factor_designs(fit: FittedModel, config: Study, *, processes: int) -> PaperDesigns:
    settings, space = config.four_factor_design, space_of_study(config)
    criterion, scene = _determinant_criterion(fit, space), coordinate_function("scene", space)
    distinct = replace(criterion, separation_coordinates=scene, separation=settings.separation)
    designs, summary = {}, {}
    for form, criterion_of_form in {"paper": criterion, "distinct": distinct}.items():
        patterns, _, summary[form] = _pattern_tables(
            form,
            criterion_of_form,
            len(fit.theta),
            settings,
            ratio=("h0_m", "hv_m"),
            processes=processes,
        )
        designs[form] = plan_table(_factor_table(patterns[0].design.points, space)).assign(
            origin=form
        )
    return designs | {"summary": {"searches": settings.searches, "forms": summary}}


def _determinant_criterion(fit: FittedModel, space: Space) -> Criterion:
    """The determinant for a fit's parameters, to the digits that they have.

    A search ends at any of equally good points; of digits that are round-off, round-off chooses.
    """
    model = get_model(fit.model)
    theta = np.array([float(f"{value:.{PARAMETER_DIGITS}g}") for value in fit.theta])

    def parameter_gradient(points: np.ndarray) -> np.ndarray:
        return model.gradient(theta, Factors.of(**dict(zip(space.names, points.T, strict=True))))

    return Criterion(parameter_gradient, space)


def _pattern_tables(
    name: str,
    criterion: Criterion,
    points: int,
    settings: Design | FourFactorDesign,
    *,
    ratio: tuple[str, str] | None = None,
    processes: int,
) -> tuple[list[DesignPattern], pd.DataFrame, list[dict[str, Any]]]:
    """The patterns that searches ended in, a row for each point of each, and what patterns are."""
    space = criterion.space
    seeds = range(settings.first_seed, settings.first_seed + settings.searches)
    designs = parallel_map(
        lambda seed: search_design(criterion, points, seed=seed), seeds, processes=processes
    )
    if ratio:
        designs = [spread_along_ratio_lines(criterion, design, ratio=ratio) for design in designs]
    patterns = find_design_patterns(designs, space)
    names = {index: pattern.name for pattern in patterns for index in pattern.design_indices}
    searches = [
        _factor_table(design.points, space).assign(search=index + 1, objective=design.value)
        for index, design in enumerate(designs)
    ]
    table = pd.concat(searches, ignore_index=True)
    table = table.assign(scaling=name, pattern=table["search"].map(lambda at: names[at - 1]))
    summaries = [
        {
            "pattern": pattern.name,
            "count": len(pattern.design_indices),
            "objective": pattern.design.value,
            "objective_excess": pattern.design.value - patterns[0].design.value,
            "points": _factor_table(pattern.design.points, space).to_dict("records"),
        }
        for pattern in patterns
    ]
    columns = ["scaling", "search", "pattern", *space.names, "objective"]
    return patterns, table[columns], summaries


def _factor_table(points: np.ndarray, space: Space) -> pd.DataFrame:
    """Points with their factors' names; twelve digits, so that a limit reads 2e-06."""
    return pd.DataFrame(round_to_twelve_digits(points), columns=list(space.names))
