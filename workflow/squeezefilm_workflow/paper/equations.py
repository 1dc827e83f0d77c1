"""The paper's study beside the same one with a gas that has inertia: does its conclusion survive?

The conclusion: a model fitted to five D-optimal points is good enough in place of one fitted to all
simulations. It survives where the five points do no worse than the paper itself reports (the claims
``design_error``, ``four_factor_error`` and ``band`` of papers_claims.csv).
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.designs.paper_design import d_efficiency
from squeezefilm.models.data import factors_of_table
from squeezefilm.models.prediction_interval import error_statistics, relative_errors
from squeezefilm_workflow.paper.claims import CLAIMS
from squeezefilm_workflow.paper.tables import parameter_rows
from squeezefilm_workflow.reporting.check import FIT_OF_DESIGN
from squeezefilm_workflow.reporting.pages import Page, readable_table
from squeezefilm_workflow.reporting.results import Results

LABEL_OF_FIT = {
    "screen": "all points, two factors",
    "two_factor_design": "five points, two factors",
    "four_factor": "all points, four factors",
    "four_factor_design": "five points, four factors, the paper's form",
    "four_factor_design_distinct": "five points, four factors, distinct scenes",
}
LABEL_OF_VALIDATION = {
    ("two_factor_design", "screen"): "all points",
    ("two_factor_design", "error_map"): "control grid",
    ("four_factor_design", "four_factor"): "all points",
    ("four_factor_design_distinct", "four_factor"): "all points",
    ("four_factor_design_distinct", "four_factor_control"): "random points",
}
EQUATION_COLUMNS = ("part", "quantity", "unit", "paper_equation", "with_inertia")
_TWO_FACTOR_DESIGN_LABEL = LABEL_OF_FIT["two_factor_design"]
_FOUR_FACTOR_DESIGN_LABEL = LABEL_OF_FIT["four_factor_design"]
CONCLUSION_CONDITIONS = (
    (_TWO_FACTOR_DESIGN_LABEL, "global error, all points", float(CLAIMS["paper"]["design_error"])),
    (
        _TWO_FACTOR_DESIGN_LABEL,
        "worst relative error, control grid",
        float(CLAIMS["upper"]["band"]),
    ),
    (
        _FOUR_FACTOR_DESIGN_LABEL,
        "global error, all points",
        float(CLAIMS["paper"]["four_factor_error"]),
    ),
)
"""What five points must hold: part and quantity of the table, the largest value the paper has."""


def equations_table(paper: Results, inertia: Results) -> pd.DataFrame:
    """A row for each number of the two studies, columns EQUATION_COLUMNS.

    Raises:
        InputError: naming a result that is missing or lacks what it must have.
    """
    pairs = zip(
        _study_value_rows(paper, design_source=paper),
        _study_value_rows(inertia, design_source=paper),
        strict=True,
    )
    rows = [(*without, value) for without, (*_, value) in pairs]
    return pd.DataFrame(
        [*rows, *_errors_of_transferred_fits(paper, inertia)], columns=list(EQUATION_COLUMNS)
    )


def _study_value_rows(
    study: Results, *, design_source: Results
) -> Iterator[tuple[str, str, str, float]]:
    """Part, quantity, unit and value, for one study; ``design_source`` has the designs to be
    reused.
    """
    forces = study.forces("extrapolation").set_index("point_id")["force_n"]
    yield "force", "at the paper's operating point", "N", forces["operating_point"]
    for name, part in LABEL_OF_FIT.items():
        fit = study.fit(name)
        for parameter in parameter_rows(fit):
            yield part, *parameter
        yield part, "global error on its own points", "%", 100 * fit.global_error
    for (name, plan), where in LABEL_OF_VALIDATION.items():
        errors = study.validation_errors(name, plan)
        yield LABEL_OF_FIT[name], f"global error, {where}", "%", 100 * errors["global_error"]
        worst = 100 * abs(errors["worst_relative_error"])
        yield LABEL_OF_FIT[name], f"worst relative error, {where}", "%", worst
    for name, fit_name in FIT_OF_DESIGN.items():
        fit = study.fit(fit_name)
        slopes = fit.force_model.gradient(fit.theta, factors_of_table(study.design(name)))
        first = fit.force_model.gradient(fit.theta, factors_of_table(design_source.design(name)))
        part = "D-efficiency of the points that the paper's equation finds"
        yield part, name.replace("_", " "), "–", d_efficiency(first, slopes)


def _errors_of_transferred_fits(
    paper: Results, inertia: Results
) -> Iterator[tuple[str, str, str, float, float]]:
    """Compare fits to the paper's equation with forces without and with inertia."""
    part = "the paper's equation judged by forces with inertia"
    for name in ("screen", "two_factor_design", "four_factor"):
        plan = "four_factor" if name == "four_factor" else "screen"
        fit, tables = paper.fit(name), [study.forces(plan) for study in (paper, inertia)]
        without, with_it = (
            _global_error_percent(
                fit.force_model.evaluate(fit.theta, factors_of_table(table)), table
            )
            for table in tables
        )
        yield part, f"global error, fit to {LABEL_OF_FIT[name]}", "%", without, with_it
    plain, moved = (study.forces("screen") for study in (paper, inertia))
    change = 100 * (moved["force_n"] / plain["force_n"] - 1)
    worst = relative_errors(model_n=plain["force_n"], simulation_n=moved["force_n"])
    for quantity, value in {
        "global error of the forces themselves": _global_error_percent(plain["force_n"], moved),
        "least change of a force": change.min(),
        "largest change of a force": change.max(),
        "worst relative error of the forces themselves": 100 * np.abs(worst).max(),
    }.items():
        yield part, f"{quantity}, screen", "%", 0.0, float(value)


def _global_error_percent(model_n: Any, forces: pd.DataFrame) -> float:
    return 100 * error_statistics(model_n=model_n, simulation_n=forces["force_n"])["global_error"]


def equations_page(results: Results, *, sides: Sequence[str]) -> Page:
    """The page of the two studies, whose results are in the folders ``sides``."""
    table = equations_table(*(Results(Path(folder), results.config) for folder in sides))
    parts = readable_table(table).groupby("part", sort=False)
    rested_on = conclusion_rows(table)
    values = {
        "survives": rested_on["holds"].all(),
        "conditions": rested_on,
        "parts": {part: rows.drop(columns="part") for part, rows in parts},
    }
    return Page(values, {"csv": table})


def conclusion_rows(table: pd.DataFrame) -> pd.DataFrame:
    """The table's rows that the conclusion rests on.

    ``at_most`` are the paper's own errors, ``holds`` says whether five points do no worse where the
    gas has inertia: the conclusion survives where all hold.
    """
    keys = [(part, quantity) for part, quantity, _ in CONCLUSION_CONDITIONS]
    rows = table.set_index(["part", "quantity"]).loc[keys].reset_index()
    at_most = np.array([limit for *_, limit in CONCLUSION_CONDITIONS])
    return rows.assign(at_most=at_most, holds=rows["with_inertia"] <= at_most)
