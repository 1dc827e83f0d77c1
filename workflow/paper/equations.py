"""The paper's study beside the same one with a gas that has inertia: does its conclusion survive?

The conclusion: a model fitted to five D-optimal points is good enough in place of one fitted to all
simulations. It survives where the five points do no worse than the paper itself reports (the claims
``design_error``, ``four_factor_error`` and ``band`` of papers_claims.csv).
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from paper.claims import CLAIMS
from paper.tables import SYMBOLS, UNITS
from reporting.results import Results
from squeezefilm.designs.paper_design import d_efficiency
from squeezefilm.models.data import Factors
from squeezefilm.tables import FACTOR_COLUMNS

FITS = {
    "screen": "all points, two factors",
    "two_factor_design": "five points, two factors",
    "four_factor": "all points, four factors",
    "four_factor_design": "five points, four factors, the paper's form",
    "four_factor_design_distinct": "five points, four factors, distinct scenes",
}
DESIGNS = {
    "two_factor": ("design, two factors", "screen"),
    "four_factor": ("design, four factors, the paper's form", "four_factor"),
    "four_factor_distinct": ("design, four factors, distinct scenes", "four_factor"),
}
"""Each design, and the fit that it was found with."""
VALIDATIONS = {
    ("two_factor_design", "screen"): "all points",
    ("two_factor_design", "error_map"): "control grid",
    ("four_factor_design", "four_factor"): "all points",
    ("four_factor_design_distinct", "four_factor"): "all points",
    ("four_factor_design_distinct", "four_factor_control"): "random points",
}
SHOWN = {
    "h0_m": ("h0", 1e6, "µm"),
    "hv_m": ("hv", 1e6, "µm"),
    "phi_r_m": ("φr", 1e3, "mm"),
    "phi_deg": ("φφ", 1.0, "°"),
}
DIGITS = {"h0_m": 8, "hv_m": 8, "phi_r_m": 5, "phi_deg": 1}
COLUMNS = ("part", "quantity", "unit", "paper_equation", "with_inertia")
_TWO, _FOUR = FITS["two_factor_design"], FITS["four_factor_design"]
CONDITIONS = (
    (_TWO, "global error, all points", float(CLAIMS["paper"]["design_error"])),
    (_TWO, "worst relative error, control grid", float(CLAIMS["largest"]["band"])),
    (_FOUR, "global error, all points", float(CLAIMS["paper"]["four_factor_error"])),
)
"""What five points must hold: part and quantity of the table, the largest value the paper has."""


def compare(paper: Results, inertia: Results) -> pd.DataFrame:
    """A row for each number of the two studies, columns COLUMNS.

    Raises:
        InputError: naming a result that is missing or lacks what it must have.
    """
    pairs = zip(_values(paper, found_by=paper), _values(inertia, found_by=paper), strict=True)
    rows = [(*without, value) for without, (*_, value) in pairs]
    part = "the paper's equation judged by forces with inertia"
    rows += [(part, *rest) for rest in _transferred(paper, inertia)]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _values(study: Results, *, found_by: Results) -> Iterator[tuple[str, str, str, float]]:
    """Part, quantity, unit and value, for one study; ``found_by`` has the designs to be reused."""
    forces = study.forces("extrapolation").set_index("point_id")["force_n"]
    yield "force", "at the paper's operating point", "N", forces["operating_point"]
    for name, part in FITS.items():
        fit = study.fit(name)
        for parameter, value in zip(fit.force_model.parameter_names, fit.theta, strict=True):
            yield part, SYMBOLS[parameter], UNITS.get(parameter, "–"), value
        yield part, "global error on its own points", "%", 100 * fit.global_error
    for (name, plan), where in VALIDATIONS.items():
        errors = study.validation(name, plan)
        yield FITS[name], f"global error, {where}", "%", 100 * errors["global_error"]
        worst = 100 * abs(errors["worst_relative_error"])
        yield FITS[name], f"worst relative error, {where}", "%", worst
    for name, (part, fit_name) in DESIGNS.items():
        fit = study.fit(fit_name)
        points = study.design(name)
        # Points of two designs beside each other, in an order that rounding does not change.
        order = points.round(DIGITS).sort_values(list(FACTOR_COLUMNS)).index
        for index, point in enumerate(points.loc[order].to_dict("records"), start=1):
            for factor in fit.force_model.factor_names:
                symbol, scale, unit = SHOWN[factor]
                yield part, f"point {index} {symbol}", unit, scale * point[factor]
        slopes, first = (
            fit.force_model.gradient(fit.theta, _factors(table))
            for table in (points, found_by.design(name))
        )
        lost = "D-efficiency of the points that the paper's equation finds"
        yield part, lost, "–", d_efficiency(first, slopes)


def _transferred(paper: Results, inertia: Results) -> Iterator[tuple[str, str, float, float]]:
    """How well fits to the paper's equation predict forces without and with inertia."""
    for name in ("screen", "two_factor_design", "four_factor"):
        plan = "four_factor" if name == "four_factor" else "screen"
        fit, tables = paper.fit(name), [study.forces(plan) for study in (paper, inertia)]
        without, with_it = (
            _global_percent(fit.force_model.evaluate(fit.theta, _factors(table)), table["force_n"])
            for table in tables
        )
        yield f"global error, fit to {FITS[name]}", "%", without, with_it
    mine, other = (study.forces("screen")["force_n"].to_numpy() for study in (paper, inertia))
    change = 100 * (other / mine - 1)
    worst = 100 * float(np.abs(mine / other - 1).max())
    yield "global error of the forces themselves, screen", "%", 0.0, _global_percent(mine, other)
    yield "least change of a force, screen", "%", 0.0, float(change.min())
    yield "largest change of a force, screen", "%", 0.0, float(change.max())
    yield "worst relative error of the forces themselves, screen", "%", 0.0, worst


def _global_percent(model_n: Any, force_n: Any) -> float:
    return float(100 * np.linalg.norm(model_n - force_n) / np.linalg.norm(force_n))


def _factors(table: pd.DataFrame) -> Factors:
    return Factors.of(**{name: table[name] for name in FACTOR_COLUMNS})


def conditions(table: pd.DataFrame) -> pd.DataFrame:
    """The table's rows that the conclusion rests on, and ``at_most``, the paper's own errors."""
    keys = [(part, quantity) for part, quantity, _ in CONDITIONS]
    rows = table.set_index(["part", "quantity"]).loc[keys].reset_index()
    return rows.assign(at_most=[limit for *_, limit in CONDITIONS])


def survives(table: pd.DataFrame, *, column: str) -> bool:
    """Whether five points are enough by the forces of a column of the table."""
    rows = conditions(table)
    return bool((rows[column] <= rows["at_most"]).all())
