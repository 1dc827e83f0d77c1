"""The paper's study beside the same one with a gas that has inertia: does its conclusion survive?

The conclusion: a model fitted to five D-optimal points is good enough in place of one fitted to all
simulations. It survives where the five points do no worse than the paper itself reports (the claims
``design_error``, ``four_factor_error`` and ``band`` of papers_claims.csv).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from paper.claims import CLAIMS
from paper.tables import SYMBOLS, UNITS, five_digits
from squeezefilm.designs.paper_design import d_efficiency
from squeezefilm.io.markdown import markdown_table
from squeezefilm.io.tables import FACTOR_COLUMNS, read_design, read_json, read_ok_forces
from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import FittedModel, number, read_fit

INPUTS = {
    "screen": "simulations/screen/forces.csv",
    "plan": "simulations/four_factor/forces.csv",
    "extrapolation": "simulations/extrapolation/forces.csv",
    "screen_fit": "fits/screen.json",
    "design_fit": "fits/two_factor_design.json",
    "plan_fit": "fits/four_factor.json",
    "plan_design_fit": "fits/four_factor_design.json",
    "plan_distinct_fit": "fits/four_factor_design_distinct.json",
    "design": "designs/two_factor.csv",
    "plan_design": "designs/four_factor.csv",
    "plan_distinct": "designs/four_factor_distinct.csv",
    "design_on_screen": "validation/two_factor_design_on_screen.json",
    "design_on_grid": "validation/two_factor_design_on_error_map.json",
    "plan_design_on_plan": "validation/four_factor_design_on_four_factor.json",
    "plan_distinct_on_plan": "validation/four_factor_design_distinct_on_four_factor.json",
    "plan_distinct_on_control": (
        "validation/four_factor_design_distinct_on_four_factor_control.json"
    ),
}
"""What is needed of either study, by name, each with its place among the study's results."""

FITS = {
    "screen_fit": "all points, two factors",
    "design_fit": "five points, two factors",
    "plan_fit": "all points, four factors",
    "plan_design_fit": "five points, four factors, the paper's form",
    "plan_distinct_fit": "five points, four factors, distinct scenes",
}
DESIGNS = {
    "design": ("design, two factors", "screen_fit"),
    "plan_design": ("design, four factors, the paper's form", "plan_fit"),
    "plan_distinct": ("design, four factors, distinct scenes", "plan_fit"),
}
"""Each design, and the fit that it was found with."""
JUDGED = {
    "design_on_screen": ("five points, two factors", "all points"),
    "design_on_grid": ("five points, two factors", "control grid"),
    "plan_design_on_plan": ("five points, four factors, the paper's form", "all points"),
    "plan_distinct_on_plan": ("five points, four factors, distinct scenes", "all points"),
    "plan_distinct_on_control": ("five points, four factors, distinct scenes", "random points"),
}
SHOWN = {
    "h0_m": ("h0", 1e6, "µm"),
    "hv_m": ("hv", 1e6, "µm"),
    "phi_r_m": ("φr", 1e3, "mm"),
    "phi_deg": ("φφ", 1.0, "°"),
}
DIGITS = {"h0_m": 8, "hv_m": 8, "phi_r_m": 5, "phi_deg": 1}
COLUMNS = ("part", "quantity", "unit", "paper_equation", "with_inertia")
HEADS = {"paper_equation": "the paper's equation", "with_inertia": "with inertia"}
Value = tuple[str, str, str, float]


@dataclass(frozen=True)
class Study:
    """What is compared of one study, by the names of INPUTS; every value is read when needed."""

    results: Path

    def path(self, name: str) -> Path:
        return self.results / INPUTS[name]

    def fit(self, name: str) -> FittedModel:
        return read_fit(self.path(name))

    def design(self, name: str) -> pd.DataFrame:
        return read_design(self.path(name))

    def forces(self, name: str) -> pd.DataFrame:
        return read_ok_forces(self.path(name))

    def judged(self, name: str, key: str) -> float:
        return number(read_json(self.path(name)), key, self.path(name))

    @property
    def operating_force_n(self) -> float:
        """The simulated force at the paper's operating point."""
        table = self.forces("extrapolation")
        return float(table.loc[table["point_id"] == "operating_point", "force_n"].iloc[0])


def compare(paper: Study, inertia: Study) -> pd.DataFrame:
    """A row for each number of the two studies, columns COLUMNS.

    Raises:
        InputError: naming a result that is missing or lacks what it must have.
    """
    pairs = zip(_values(paper, found_by=paper), _values(inertia, found_by=paper), strict=True)
    rows = [(*mine[:3], mine[3], theirs[3]) for mine, theirs in pairs]
    rows += [
        ("the paper's equation judged by forces with inertia", *rest)
        for rest in _transferred(paper, inertia)
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _values(study: Study, *, found_by: Study) -> Iterator[Value]:
    """Part, quantity, unit and value, for one study; ``found_by`` has the designs to be reused."""
    yield "force", "at the paper's operating point", "N", study.operating_force_n
    for name, part in FITS.items():
        fit = study.fit(name)
        for parameter, value in zip(fit.force_model.parameter_names, fit.theta, strict=True):
            yield part, SYMBOLS[parameter], UNITS.get(parameter, "–"), value
        yield part, "global error on its own points", "%", 100 * fit.global_error
    for name, (part, where) in JUDGED.items():
        yield part, f"global error, {where}", "%", 100 * study.judged(name, "global_error")
        worst = abs(study.judged(name, "worst_relative_error"))
        yield part, f"worst relative error, {where}", "%", 100 * worst
    for name, (part, fit_name) in DESIGNS.items():
        fit = study.fit(fit_name)
        points = _ordered(study.design(name))
        for index, point in enumerate(points.to_dict("records"), start=1):
            for factor in fit.force_model.factor_names:
                symbol, scale, unit = SHOWN[factor]
                yield part, f"point {index} {symbol}", unit, scale * point[factor]
        slopes, first = (
            fit.force_model.gradient(fit.theta, _factors(table))
            for table in (points, found_by.design(name))
        )
        lost = "D-efficiency of the points that the paper's equation finds"
        yield part, lost, "–", d_efficiency(first, slopes)


def _transferred(paper: Study, inertia: Study) -> Iterator[tuple[str, str, float, float]]:
    """How well fits to the paper's equation say forces without and with inertia."""
    plans = {"screen_fit": "screen", "design_fit": "screen", "plan_fit": "plan"}
    for fit_name, plan in plans.items():
        fit = paper.fit(fit_name)
        errors = []
        for study in (paper, inertia):
            forces = study.forces(plan)
            model_n = fit.force_model.evaluate(fit.theta, _factors(forces))
            errors.append(_global_percent(model_n, forces["force_n"].to_numpy()))
        yield (f"global error, fit to {FITS[fit_name]}", "%", errors[0], errors[1])
    mine, theirs = (study.forces("screen")["force_n"].to_numpy() for study in (paper, inertia))
    yield "global error of the forces themselves, screen", "%", 0.0, _global_percent(mine, theirs)
    change = 100 * (theirs / mine - 1)
    yield "least change of a force, screen", "%", 0.0, float(change.min())
    yield "largest change of a force, screen", "%", 0.0, float(change.max())
    worst = 100 * float(np.abs(mine / theirs - 1).max())
    yield "worst relative error of the forces themselves, screen", "%", 0.0, worst


def _global_percent(model_n: np.ndarray, force_n: np.ndarray) -> float:
    return float(100 * np.linalg.norm(model_n - force_n) / np.linalg.norm(force_n))


def _ordered(points: pd.DataFrame) -> pd.DataFrame:
    """Points by gap and amplitude, so that those of two designs stand beside each other."""
    # What is the same gap but for rounding must not change the order.
    rounded = points[list(FACTOR_COLUMNS)].round(DIGITS)
    order = rounded.sort_values(list(FACTOR_COLUMNS)).index
    return points.loc[order].reset_index(drop=True)


def _factors(table: pd.DataFrame) -> Factors:
    return Factors.of(**{name: table[name] for name in FACTOR_COLUMNS})


@dataclass(frozen=True)
class Condition:
    """What five points must hold: a row of the table, and the largest value that the paper has."""

    part: str
    quantity: str
    largest: float


def conditions() -> tuple[Condition, ...]:
    """Of the conclusion that five points are enough, with the paper's own errors."""
    claims = {claim.claim_id: claim for claim in CLAIMS}
    two, four = "five points, two factors", "five points, four factors, the paper's form"
    return (
        Condition(two, "global error, all points", float(claims["design_error"].paper)),
        Condition(two, "worst relative error, control grid", claims["band"].largest),
        Condition(four, "global error, all points", float(claims["four_factor_error"].paper)),
    )


def survives(table: pd.DataFrame, *, column: str) -> bool:
    """Whether five points are enough by the forces of a column of the table."""
    return all(_value(table, each, column) <= each.largest for each in conditions())


def _value(table: pd.DataFrame, condition: Condition, column: str) -> float:
    rows = (table["part"] == condition.part) & (table["quantity"] == condition.quantity)
    return float(table.loc[rows, column].iloc[0])


def to_markdown(table: pd.DataFrame) -> str:
    """The comparison for people: the verdict first."""
    verdict = "survives" if survives(table, column="with_inertia") else "does not survive"
    conditions_met = pd.DataFrame(
        [
            (
                f"{each.part}: {each.quantity}",
                *(_shown_percent(_value(table, each, column)) for column in COLUMNS[-2:]),
                _shown_percent(each.largest),
            )
            for each in conditions()
        ],
        columns=["error", *HEADS.values(), "at most, as in the paper"],
    )
    parts = [
        "# The paper's equation and a gas that has inertia\n",
        f"The paper's conclusion, five points are enough, **{verdict}** where the gas has inertia: "
        "it is taken to survive where the model fitted to five points does no worse than the paper "
        "reports.\n",
        markdown_table(conditions_met),
        "Both studies have the same space, plans, seeds and tolerance. Points of designs are in "
        "the order of their gaps and amplitudes; of points with equal hv/h0, which teach the model "
        "of four factors the same, the one far from the others is taken.\n",
    ]
    for part, rows in table.groupby("part", sort=False):
        parts += [f"## {str(part)[0].upper()}{str(part)[1:]}\n", markdown_table(_shown(rows))]
    return "\n".join(parts)


def _shown(rows: pd.DataFrame) -> pd.DataFrame:
    named = {head: rows[column].map(five_digits) for column, head in HEADS.items()}
    return pd.DataFrame({"quantity": rows["quantity"], "unit": rows["unit"], **named})


def _shown_percent(value: float) -> str:
    return f"{value:.3g} %"
