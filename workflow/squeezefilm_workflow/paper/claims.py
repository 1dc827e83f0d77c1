"""The paper's claims beside ours, each with a verdict by a rule that is written down.

papers_claims.csv has what the paper claims, whether that is a result or a setting that a study
takes from the paper, which size of a plan decides it, in which interval our
value agrees with it, how our value is shown, and what a reader should know of it: texts in which
the names in braces are values of the results. The intervals follow from what the paper states and
with how many digits; no number of ours is fitted to it, but where it is silent the reading nearest
to it was chosen (docs/explanation/paper.md). The reasons in ``because`` are what we know; a guess
is called a guess.
"""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.formatting import column_label, interval_text, percent_text
from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import FittedModel
from squeezefilm.solution import MODELLING_ERROR_COLUMNS
from squeezefilm.tables import read_timings
from squeezefilm_workflow.reporting.results import Results

CLAIM_COLUMNS = ("claim_id", "kind", "claim", "paper", "ours", "unit", "verdict", "explanation")
CLAIMS = pd.read_csv(
    Path(__file__).with_name("papers_claims.csv"),
    dtype={"paper": str},
    keep_default_na=False,
    index_col="claim_id",
)
PAPER_FACTOR_LIMITS_UM = {"hv_min": 0.2, "hv_max": 2.0, "h0_min": 5.0, "h0_max": 10.0}
TIME_BOUNDS_AND_TEXTS = ((1.0, "1 s"), (60.0, "1 min"), (3600.0, "1 h"), (86400.0, "1 day"))

ClaimValues = dict[str, Any]
"""Our value of each claim by its id, in the claim's unit, and others that texts name: lengths in
µm, forces in N, errors in percent."""


def claims_with_verdicts(results: Results) -> pd.DataFrame:
    """Every claim with our value and the verdict, as strings; columns CLAIM_COLUMNS.

    Raises InputError naming a result that is missing or lacks what it must have.
    """
    values = (
        _two_factor_values(results)
        | _design_values(results)
        | _operating_point_values(results)
        | _four_factor_values(results)
    )
    claims = CLAIMS.reset_index().apply(lambda claim: _with_verdict(claim, values), axis="columns")
    return claims[list(CLAIM_COLUMNS)]


def _with_verdict(claim: pd.Series, values: Mapping[str, Any]) -> pd.Series:
    """The claim with its texts filled in and the verdict."""
    ours = values[claim["claim_id"]]
    size, needed = claim["size"], int(claim["needed"] or 0)
    if needed and values[size] < needed:
        words = size.replace("_", " ")
        claim["verdict"] = f"undecided with {values[size]} of the paper's {needed} {words}"
    else:
        agrees = claim["lower"] <= ours <= claim["upper"]
        claim["verdict"] = verdict_text(agrees, within=claim["within"], because=claim["because"])
    for text in ("ours", "explanation"):
        claim[text] = re.sub(r"-(?=\d)", "−", claim[text].format(value=ours, **values))
    return claim


def verdict_text(agrees: bool, *, within: str, because: str) -> str:
    """Return the verdict on a claim with its criterion, and the reason where it differs."""
    return f"agrees {within}" if agrees else f"differs (would agree {within}) because {because}"


def _two_factor_values(results: Results) -> ClaimValues:
    """Return values of the screen, its fit, its forces and their times."""
    screen, fit = _with_micrometre_columns(results.forces("screen")), results.fit("screen")
    limits = {
        f"{name}_{end}": round(float(screen[f"{name}_um"].agg(end)), 6)
        for name in ("hv", "h0")
        for end in ("min", "max")
    }
    runs = results.table("fits/screen_runs.csv", "bound", "sum_of_squares")
    bounds = sorted(runs["bound"].unique())
    spread = float(runs["sum_of_squares"].max() / runs["sum_of_squares"].min() - 1)
    same = "the same" if spread < 1e-6 else f"sum of squares up to {spread:.1g} apart"
    smallest = screen.sort_values("force_n", kind="stable").iloc[0]
    ppm = 1e6 * float(smallest["force_n"])
    seconds = read_timings(results.folder / "simulations/screen/timings.csv")["solve_s"].max()
    bound = next(
        (f"below {name}" for limit, name in TIME_BOUNDS_AND_TEXTS if seconds < limit), None
    )
    return {
        **limits,
        "space": max(abs(limits[name] - value) for name, value in PAPER_FACTOR_LIMITS_UM.items()),
        "screen_points": len(screen),
        "gaps": screen["h0_m"].nunique(),
        "amplitudes": screen["hv_m"].nunique(),
        "bounds": spread if len(bounds) > 1 else math.inf,
        "search_bounds": len(bounds),
        "bounds_shown": same if len(bounds) > 1 else "one bound only",
        "bounds_tried": ", ".join(f"±{bound:g}" for bound in bounds),
        "runs": len(runs),
        "theta": math.log10(max(map(abs, fit.theta)) / 10),
        "theta_shown": ", ".join(f"{value:.4g}" for value in fit.theta),
        "screen_error": 100 * results.validation_errors("screen", "screen")["global_error"],
        "smallest_force": ppm,
        "smallest": smallest,
        "needed_um": smallest["hv_um"] * math.sqrt(90 / ppm) if ppm > 0 else math.nan,
        "seconds": float(seconds) / 86400,
        "seconds_shown": bound or "a day or more",
    }


def _design_values(results: Results) -> ClaimValues:
    """Return values of the searches for a design, the design, and the fit to its points."""
    screen, design = results.forces("screen"), results.design("two_factor")
    fit = results.fit("two_factor_design")
    judged = results.validation_errors("two_factor_design", "screen")
    summary = results.read_json_file("designs/two_factor.json")
    scalings, own = summary["scalings"], summary["scaling"]
    patterns = scalings[own]
    excess = max(pattern["objective_excess"] for pattern in patterns)
    return {
        **_fit_error_values(results),
        "design_error": 100 * judged["global_error"],
        "fitted": fit.points,
        "judged": round(judged["points"]),
        "sum_of_squares": judged["sum_of_squares"] / results.fit("screen").sum_of_squares,
        "patterns": len(patterns),
        "searches": summary["searches"],
        "counts": "; ".join(
            name.replace("unit", "scaled to [0, 1]")
            + ": "
            + ", ".join(f"{pattern['pattern']} {pattern['count']}" for pattern in table)
            for name, table in sorted(scalings.items(), key=lambda item: item[0] != own)
        ),
        "behind": excess / patterns[0]["objective"],
        "union": int((design["origin"] != "augmentation").sum()),
        "reduction": len(screen) / len(design),
        "design": len(design),
        "saved": len(screen) - len(design),
        "together": len(screen) + len(design),
        "smallest_of_design": int((design["hv_m"] <= screen["hv_m"].min() * (1 + 1e-9)).sum()),
    }


def _fit_error_values(results: Results) -> ClaimValues:
    """Return the larger of both fits' errors on the screen, and the values of each.

    Values of the fit to five points end in ``_five``, those of the fit to all points in ``_all``.
    """
    values: ClaimValues = {}
    for name, end in (("two_factor_design", "five"), ("screen", "all")):
        errors = _with_micrometre_columns(results.errors(name, "screen"))
        smallest = np.isclose(errors["hv_um"], errors["hv_um"].min(), rtol=1e-9)
        percent = 100 * errors["relative_error"].abs()
        values |= {
            "least_um": errors["hv_um"].min(),
            f"band_{end}": percent[~smallest].max(),
            f"band_small_{end}": percent[smallest].max(),
            f"outside_{end}": int((percent > CLAIMS["upper"]["band"]).sum()),
            f"limit_{end}": _predicted_force_n(results.fit(name), h0_m=1.0, hv_m=0.0),
        }
    for name in ("band", "limit"):
        values[name] = max(values[f"{name}_five"], values[f"{name}_all"], key=abs)
    return values | {"band_small": values["band_small_five"]}  # Fig. 14 of the paper is of this fit


def _operating_point_values(results: Results) -> ClaimValues:
    """Return values of the forces and neglected effects at the paper's operating point."""
    file = "simulations/extrapolation/forces.csv"
    table = _with_micrometre_columns(results.forces("extrapolation")).set_index("point_id")
    point = results.row(table, "operating_point", file)
    wanted = results.row(table, "two_factor_design", file)
    fit = results.fit("two_factor_design")
    expected_n = _predicted_force_n(fit, h0_m=point["h0_m"], hv_m=point["hv_m"])
    effects = ("point_id", "edge_loss_percent", "edge_loss_upper_percent")
    budgets = results.budget("extrapolation", *effects).set_index("point_id")
    budget = results.row(budgets, "operating_point", "simulations/extrapolation/error_budget.csv")
    present = [name for name in budget["included_effects"].split("; ") if name]
    included = f"With {' and '.join(present)} in it, which eq. (1) neglects; still neglected are"
    return {
        "model_at_2.2": expected_n,
        "model_all": _predicted_force_n(
            results.fit("screen"), h0_m=point["h0_m"], hv_m=point["hv_m"]
        ),
        "amplitude_all": results.row(table, "screen", file)["hv_um"],
        "of_ours": 100 * expected_n / point["force_n"],
        "simulation_at_2.2": point["force_n"],
        "of_paper": 100 * point["force_n"] / 0.99,
        "point": point,
        "wanted": wanted,
        "budget": budget,
        "equation": included if present else "Eq. (1) neglects",
        "effects": ", ".join(
            f"{column_label(name)} {percent_text(budget[f'{name}_percent'])}"
            for name in ("inertia", "slip", "thermal")
            if name not in present
        ),
        "interval": interval_text(
            *point["force_n"] * (1 + budget[MODELLING_ERROR_COLUMNS].astype(float) / 100),
            sign="",
            digits=3,
        ),
        "amplitude": wanted["hv_um"],
    }


def _four_factor_values(results: Results) -> ClaimValues:
    """Return values of the plan, the designs and the fits with four factors.

    locus: largest distance of hv/h0 of an optimum from the nearest of the two-factor design, in
    percent of the largest hv/h0. The model knows h0 and hv by their ratio alone, so that all
    points on a line of equal hv/h0 are as good.
    """
    plan = results.forces("four_factor")
    designs = [results.design(name) for name in ("two_factor", "four_factor")]
    two, four = ((design["hv_m"] / design["h0_m"]).to_numpy() for design in designs)
    distance = np.abs(four[:, None] - two[None, :]).min(axis=1) / two.max()
    judged = results.validation_errors("four_factor_design", "four_factor")
    distinct = results.validation_errors("four_factor_design_distinct", "four_factor")
    control = results.validation_errors("four_factor_design_distinct", "four_factor_control")
    return {
        "four_factor_points": len(plan),
        "positions": len(plan[["phi_r_m", "phi_deg"]].drop_duplicates()),
        "locus": 100 * distance.max(),
        "four": _distinct_values_text(four),
        "two": _distinct_values_text(two),
        "four_factor_error": 100 * judged["global_error"],
        "distinct": 100 * distinct["global_error"],
        "control": 100 * control["global_error"],
        "random": round(control["points"]),
        "four_factor_reduction": len(plan) / len(four),
        "four_factor_design": len(four),
        "four_factor_saved": len(plan) - len(four),
    }


def _with_micrometre_columns(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(h0_um=1e6 * table["h0_m"], hv_um=1e6 * table["hv_m"])


def _predicted_force_n(fit: FittedModel, *, h0_m: float, hv_m: float) -> float:
    """The force that a fit expects with the pad centred."""
    return float(fit.force_model.evaluate(fit.theta, Factors.of(h0_m=h0_m, hv_m=hv_m))[0])


def _distinct_values_text(values: np.ndarray) -> str:
    return ", ".join(f"{value:.3f}" for value in sorted(set(values.round(3))))
