"""What a finished study is checked by: every quantity with its place, its numbers, its tolerance.

Figures' data stand before what they are made from, for they are what a reviewer looks at. How close
a number must be follows from the tolerance that the solver was asked for. On any machine and device
a force lies within it of the truth, so that two machines differ by no more than twice as much. What
follows from forces differs in proportion (docs/explanation/paper.md).
"""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reporting.check.compare import (
    BY_CHANCE,
    PLACE_OF_PICTURES,
    SAME,
    Close,
    Quantity,
    compare,
    on_screen,
    picture_quantities,
    read_reference,
    summary,
)
from reporting.pages import Page
from reporting.results import Results
from squeezefilm.models.data import factors_of
from squeezefilm.solution import form_of

SAMPLE = 25
"""Rows of a table that a reference keeps; least, mean and largest stand for the others."""
FIT_OF_DESIGN = {
    "two_factor": "screen",
    "four_factor": "four_factor",
    "four_factor_distinct": "four_factor",
}
RESULTS = {
    "simulations/screen/budget": "h0_m|hv_m|(inertia|slip|heat|rim|left_out.*)_percent",
    "simulations/four_factor/budget": "(inertia|slip|heat|rim|left_out.*)_percent",
    "simulations/screen/response": "h0_m|hv_m|corner_hz|prompt_share|error",
    "simulations/screen/gains": "h0_m|hv_m|frequency_hz|gain|phase_deg",
    "simulations/screen/levitation": "load_n|hv_m|h0_m|stiffness_n_per_m|modified_reynolds",
    "simulations/extrapolation/film": "phase_deg|x_mm|surface_um|finger_um|overpressure_kpa",
    "validation/two_factor_design_on_error_map": "h0_m|hv_m|relative_error",
    "tables/uncertainty": "assumption|force_(low|high)_n|ours_n|verdict",
}
"""Tables that the study's figures are drawn from, and their columns that are compared."""
GIVEN_PLAN = "(screen|error_map|four_factor_control)"
COLUMNS = {
    rf"{GIVEN_PLAN} force_n": "force",
    rf"{GIVEN_PLAN} (h0_m|hv_m|phi_r_m|phi_deg|x_m|y_m)": "given",
    r"\w+ (phi_r_m|phi_deg|x_m|y_m)|[a-z]\w+ (h0_m|hv_m)": "place",
    r".*/levitation h0_m": "force",
    r".* (h0_m|hv_m|minimum|maximum)": "given",
    r"fig1[01236] (epsilon|h0_um|hv_um|phi_r_mm|phi_deg)": "place",
    r"fig.. (epsilon|\w+_(um|mm|deg)|amplitude_ratio|points|band_percent)": "given",
    r".* force_n": "model",
    r".* relative_error(_percent)?": "relative error",
    r".* value": "parameters",
}
"""How close a column of numbers is, by its table and name; the first that fits, else derived."""


def tolerances(solver: float) -> dict[str, Close]:
    """How close quantities are, by their kind, of a study whose forces have this tolerance."""
    return {
        # What the configuration gives, through plain arithmetic.
        "given": Close(relative=1e-9, of_largest=1e-12),
        # Derived in several steps, and local pressures, which the solver's tolerance is not of.
        "derived": Close(of_largest=0.01),
        # An optimum is flat: its place is known to the root of its value's accuracy.
        "place": Close(of_largest=1e-3),
        "design": Close(relative=1e-3),
        "force": Close(relative=2 * solver),
        # Errors of forces pass to fitted ones about one to one, also from five points.
        "model": Close(of_largest=4 * solver + 1e-7),
        # Norms of residuals over those of the forces move no more than the forces do.
        "residual": Close(absolute=4 * solver + 1e-7),
        # Errors of forces reach parameters sevenfold, and more in combination.
        "parameters": Close(relative=100 * solver + 1e-4, of_largest=100 * solver + 1e-6),
        # As a text shows it: where the digits shown are more than are known, those.
        "shown": Close(relative=20 * solver, digits=1),
        # A plan's smallest forces are hundreds of times smaller than the largest.
        "relative error": Close(of_largest=min(0.05, 1e4 * solver)),
    }


def check_page(results: Results, *, reference: str) -> Page:
    """Every quantity of a study beside those of the reference in a folder."""
    folder = Path(reference)
    table = compare(study_quantities(results, folder), read_reference(folder))
    shown = table.assign(of_tolerance=table["of_tolerance"].map("{:.2g}".format))
    values = {"summary": summary(table), "table": shown}
    return Page(values, {"csv": table, "text": f"{on_screen(table)}\n"})


def study_quantities(results: Results, reference: Path) -> list[Quantity]:
    """All quantities of a finished study, in the order in which they are judged.

    A file that is missing has none; those that a reference has of it then fail.

    Raises InputError naming a file that cannot be read or lacks what it must have.

    Args:
        reference: the folder with the pictures to compare the study's with.
    """
    config, folder = results.config, results.folder

    def names(pattern: str) -> list[str]:
        return sorted(path.stem for path in folder.glob(pattern))

    close = tolerances(float(config["solver"]["tolerance"]))
    plans = sorted(path.parent.name for path in folder.glob("simulations/*/forces.csv"))
    items = [
        *(("figure data", name, _table) for name in names("figures/fig*.csv") if name != BY_CHANCE),
        *(("results", name, _table) for name in RESULTS if results.exists(f"{name}.csv")),
        *(("tables", name, _table) for name in names("tables/table*.csv")),
        *(("claims", name, _claims) for name in names("claims.csv")),
        *(("simulations", plan, _simulations) for plan in plans if plan[:10] != "validation"),
        *(("fits", name, _fit) for name in names("fits/*.json")),
        *(("designs", name, _design) for name in FIT_OF_DESIGN),
    ]
    # A reference has a sample of the films; all of them take minutes.
    if config["numerics"]["extent"] == "sample" and results.exists("numerics/stability.csv"):
        items.append(("numerics", "stability", _stability))
    quantities = [each for part, item, make in items for each in make(results, close, part, item)]
    return [*quantities, *picture_quantities(folder / PLACE_OF_PICTURES, reference)]


def text_of(value: Any) -> str:
    """A cell's text: twelve digits of a number, so that 7e-06 reads so."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.number):
        return str(value)
    return f"{float(value):.12g}"


def column_quantities(
    table: pd.DataFrame, close: Mapping[str, Close], part: str, item: str
) -> Iterator[Quantity]:
    """A table's number of rows, then its columns thinned out, each as close as in COLUMNS.

    Of a longer table, SAMPLE rows evenly spaced are kept, and of its columns of numbers the
    least, the mean and the largest value.
    """
    yield Quantity(part, item, "rows", {"rows": str(len(table))})
    for name in map(str, table):
        column, place = table[name], f"{item} {name}"
        kinds = (kind for pattern, kind in COLUMNS.items() if re.fullmatch(pattern, place))
        kind = next(kinds, "derived" if column.dtype == float else None)
        cells = _sample(column)
        if kind and len(table) > SAMPLE:
            extremes = column.agg(["min", "mean", "max"]).set_axis(["least", "mean", "largest"])
            cells |= {str(name): text_of(value) for name, value in extremes.items()}
        yield Quantity(part, item, name, cells, close[kind] if kind else SAME)


def _sample(column: pd.Series) -> dict[str, str]:
    kept = sorted({round(row) for row in np.linspace(0, len(column) - 1, SAMPLE)})
    return {f"row {row + 1}": text_of(column.iloc[row]) for row in kept}


Made = Iterator[Quantity]
Kinds = Mapping[str, Close]


def _table(results: Results, close: Kinds, part: str, item: str) -> Made:
    """A table of the paper, or one that a figure draws."""
    folder = {"figure data": "figures/", "tables": "tables/"}.get(part, "")
    table = results.table(f"{folder}{item}.csv")
    chosen = [name for name in table if re.fullmatch(RESULTS.get(item, ".*"), str(name))]
    return column_quantities(table[chosen], close, part, item)


def _claims(results: Results, close: Kinds, part: str, item: str) -> Made:
    """Every claim's verdict and our value; of the run time, the verdict alone."""
    table = results.table(f"{item}.csv", "claim_id", "claim", "paper", "ours", "unit", "verdict")
    for claim in table.fillna("").astype(str).to_dict("records"):
        name = claim["claim_id"]
        agrees = claim["verdict"].partition(" ")[0]
        yield Quantity(part, name, "verdict", {claim["claim"]: agrees})
        if name != "seconds":
            cells = {f"ours, in {claim['unit']}; paper: {claim['paper']}": claim["ours"]}
            yield Quantity(part, name, "ours", cells, close["shown"])


def _simulations(results: Results, close: Kinds, part: str, item: str) -> Made:
    """The points of a plan, their forces, and whether error estimates keep the tolerance."""
    forces = results.forces(item)
    shown = forces[["point_id", "h0_m", "hv_m", *form_of(forces), "force_n"]]
    yield from column_quantities(shown, close, part, item)
    largest = (forces["force_error_n"] / forces["force_n"].abs()).max()
    kept = {"of all points": str(largest <= results.config["solver"]["tolerance"])}
    yield Quantity(part, item, "estimated errors within the tolerance", kept)


def _fit(results: Results, close: Kinds, part: str, item: str) -> Made:
    """A fit's objective, and what it predicts at the points of its plan."""
    fit = results.fit(item)
    objective = {"|y − η|/|y|": f"{fit.global_error:.9g}"}
    yield Quantity(part, item, "objective", objective, close["residual"])
    forces = fit.force_model.evaluate(fit.theta, factors_of(results.scenes(item)))
    yield Quantity(part, item, "predicted forces", _sample(pd.Series(forces)), close["model"])


def _design(results: Results, close: Kinds, part: str, item: str) -> Made:
    """How much a design teaches of the model that it was made for: its D-efficiency times that
    of the best one."""
    fit, design = results.fit(FIT_OF_DESIGN[item]), results.design(item)
    slopes = fit.force_model.gradient(fit.theta, factors_of(design))
    sign, logarithm = np.linalg.slogdet(slopes.T @ slopes / len(slopes))
    worth = {"det(F'F/N)^(1/p)": text_of(sign * np.exp(logarithm / len(fit.theta)))}
    yield Quantity(part, item, "D-efficiency", worth, close["design"])


def _stability(results: Results, close: Kinds, part: str, item: str) -> Made:
    """The verdict on every stiff or extreme film."""
    table = results.table("numerics/stability.csv", "case", "verdict").astype(str)
    verdicts = dict(zip(table["case"], table["verdict"], strict=True))
    yield Quantity(part, item, "verdicts", verdicts)
