"""Tables I to III of the paper, with our values: the paper's own are not legible to us."""

from collections.abc import Callable, Iterator, Sequence

import pandas as pd

from squeezefilm.models.fit_file import FittedModel
from squeezefilm_workflow.reporting.notes import five_digit_text, simulation_error_note
from squeezefilm_workflow.reporting.pages import Page
from squeezefilm_workflow.reporting.results import Results

SYMBOL_OF_PARAMETER = {
    "theta0": "θ0",
    "theta1": "θ1",
    "theta2": "θ2",
    "theta3": "θ3",
    "theta4": "θ4",
}
ASSUMPTION_NOTE = "our assumption: the paper's table is not legible to us"


def table1_page(results: Results) -> Page:
    """Parameters of the two-factor model, from the screen and from the optimal design alone."""
    fits = (("screen", "screen"), ("optimal design", "two_factor_design"))
    title = "Table I. Parameters of the two-factor model"
    return _parameters_page(results, fits, plan="screen", title=title)


def table2_page(results: Results) -> Page:
    """The space of four factors: gap and amplitude are the paper's, positions our assumption."""
    screen, plan = results.scenes("screen"), results.scenes("four_factor")
    rows = [
        ("mean gap", "h0", "µm", 1e6 * screen["h0_m"], "paper"),
        ("amplitude at the centre", "hv", "µm", 1e6 * screen["hv_m"], "paper"),
        ("radial position", "r", "mm", 1e3 * plan["phi_r_m"], ASSUMPTION_NOTE),
        ("angular position", "φ", "°", plan["phi_deg"], ASSUMPTION_NOTE),
    ]
    columns = ["factor", "symbol", "unit", "minimum", "maximum", "source"]
    data = pd.DataFrame(
        [(*about, values.min(), values.max(), source) for *about, values, source in rows],
        columns=columns,
    ).round(9)
    positions = len(plan[["phi_r_m", "phi_deg"]].drop_duplicates())
    limits = {name: data[name].map("{:g}".format) for name in ("minimum", "maximum")}
    values = {
        "title": "Table II. Space of the experiment with four factors",
        "shown": data.assign(**limits),
        "note": f"{len(plan)} simulations at {positions} positions of the pad's centre.",
    }
    return Page(values, {"csv": data})


def table3_page(results: Results) -> Page:
    """Parameters of the four-factor model, from the plan and from two optimal designs alone."""
    fits = (
        ("plan", "four_factor"),
        ("optimal design, the paper's form", "four_factor_design"),
        ("optimal design, distinct scenes", "four_factor_design_distinct"),
    )
    title = "Table III. Parameters of the four-factor model"
    return _parameters_page(results, fits, plan="four_factor", title=title)


PAPER_TABLE_FUNCTIONS: dict[str, Callable[[Results], Page]] = {
    "1": table1_page,
    "2": table2_page,
    "3": table3_page,
}


def parameter_rows(fit: FittedModel) -> Iterator[tuple[str, str, float]]:
    """Symbol, unit and value of each parameter; the formula gives the number of newtons."""
    model = fit.force_model
    for name, unit, value in zip(
        model.parameter_names, model.parameter_units, fit.theta, strict=True
    ):
        yield SYMBOL_OF_PARAMETER[name], unit.replace("deg", "°") if unit != "1" else "–", value


def _parameters_page(
    results: Results, fits: Sequence[tuple[str, str]], *, plan: str, title: str
) -> Page:
    """The parameters of fits and their errors on the points of a plan, to which the first is."""
    rows = []
    judged_on = f"{results.fit(fits[0][1]).points} points of the {fits[0][0]}"
    for shown, name in fits:
        fit = results.fit(name)
        rows += [(shown, fit.points, *parameter) for parameter in parameter_rows(fit)]
        error = (
            fit.global_error
            if name == plan
            else results.validation_errors(name, plan)["global_error"]
        )
        rows.append((shown, fit.points, f"global error on the {judged_on}", "%", 100 * error))
    data = pd.DataFrame(rows, columns=["fit", "points", "quantity", "unit", "value"])
    note = f"{simulation_error_note(results.forces(plan))} The formula gives F in newtons."
    if plan == "four_factor":
        note += (
            " The formula takes φ in degrees and r in metres. θ3 is zero where a design has one "
            "scene at two angles of radius 0."
        )
    return Page({"title": title, "shown": _fits_side_by_side(data), "note": note}, {"csv": data})


def _fits_side_by_side(data: pd.DataFrame) -> pd.DataFrame:
    """A row per quantity, a column per fit, five digits."""
    table = data.assign(
        fit=data["fit"] + " (" + data["points"].astype(str) + " points)",
        value=data["value"].map(five_digit_text),
    )
    wide = table.set_index(["quantity", "unit", "fit"])["value"].unstack(sort=False)
    return wide.reset_index()
