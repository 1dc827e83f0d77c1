"""The paper's claims beside ours, each with a verdict by a rule that is written down.

papers_claims.csv says what the paper claims, of which interval our value agrees with it, how our
value is shown, and what a reader should know of it: texts in which the names in braces are values
of the results. The intervals were set from what the paper states and with how many digits, and
reviewed; nothing was tuned to make a claim agree. The reasons in ``because`` are what we know; a
guess is called a guess.
"""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reporting.results import Results
from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import FittedModel
from squeezefilm.tables import read_timings

COLUMNS = ("claim_id", "claim", "paper", "ours", "unit", "verdict", "explanation")
CLAIMS = pd.read_csv(
    Path(__file__).with_name("papers_claims.csv"),
    dtype={"paper": str},
    keep_default_na=False,
    index_col="claim_id",
)
PAPERS_SPACE = {"hv_min": 0.2, "hv_max": 2.0, "h0_min": 5.0, "h0_max": 10.0}
TIME_BOUNDS = ((1.0, "1 s"), (60.0, "1 min"), (3600.0, "1 h"), (86400.0, "1 day"))

Values = dict[str, Any]
"""Our ``value`` in a claim's unit, and others that its texts name."""


def judge(results: Results) -> pd.DataFrame:
    """Every claim with our value and the verdict, as strings; columns COLUMNS.

    Raises InputError naming a result that is missing or lacks what it must have.
    """
    values = claim_values(results)
    claims = CLAIMS.reset_index().apply(lambda claim: _judged(claim, values), axis="columns")
    return claims[list(COLUMNS)]


def _judged(claim: pd.Series, values: Mapping[str, Values]) -> pd.Series:
    """The claim with its texts filled in and the verdict."""
    ours = values[claim["claim_id"]]
    agrees = claim["least"] <= ours["value"] <= claim["largest"]
    claim["verdict"] = (
        f"agrees {claim['within']}" if agrees else f"differs because {claim['because']}"
    )
    for text in ("ours", "explanation"):
        claim[text] = re.sub(r"-(?=\d)", "−", claim[text].format(**ours))
    return claim


def claim_values(results: Results) -> dict[str, Values]:
    """Our values by the claim's id; lengths in m, forces in N, errors in percent."""
    return (
        _two_factor_values(results)
        | _design_values(results)
        | _extrapolated_values(results)
        | _four_factor_values(results)
    )


def _two_factor_values(results: Results) -> dict[str, Values]:
    """Of the screen, its fit, its forces and their times."""
    screen, fit = results.forces("screen"), results.fit("screen")
    h0_um, hv_um = 1e6 * screen["h0_m"], 1e6 * screen["hv_m"]
    limits = dict(
        zip(PAPERS_SPACE, (hv_um.min(), hv_um.max(), h0_um.min(), h0_um.max()), strict=True)
    )
    runs = results.table("fits/screen_runs.csv", "bound", "sum_of_squares")
    bounds = sorted(runs["bound"].unique())
    spread = float(runs["sum_of_squares"].max() / runs["sum_of_squares"].min() - 1)
    same = "the same" if spread < 1e-6 else f"sum of squares up to {spread:.1g} apart"
    smallest = screen.sort_values("force_n", kind="stable").iloc[0]
    ppm = 1e6 * float(smallest["force_n"])
    seconds = read_timings(results.folder / "simulations/screen/timings.csv")["solve_seconds"].max()
    bound = next((name for limit, name in TIME_BOUNDS if seconds < limit), None)
    return {
        "space": {
            "value": max(abs(limits[name] - value) for name, value in PAPERS_SPACE.items()),
            **{name: round(value, 6) for name, value in limits.items()},
        },
        "screen_points": {
            "value": len(screen),
            "gaps": screen["h0_m"].nunique(),
            "amplitudes": screen["hv_m"].nunique(),
        },
        "bounds": {
            "value": spread if len(bounds) > 1 else math.inf,
            "shown": same if len(bounds) > 1 else "one bound only",
            "runs": len(runs),
            "bounds": ", ".join(f"±{bound:g}" for bound in bounds),
        },
        "theta": {
            "value": math.log10(max(map(abs, fit.theta)) / 10),
            "theta": ", ".join(f"{value:.4g}" for value in fit.theta),
        },
        "screen_error": {"value": 100 * results.validation("screen", "screen")["global_error"]},
        "smallest_force": {
            "value": ppm,
            **_place(smallest),
            "needed_um": 1e6 * smallest["hv_m"] * math.sqrt(90 / ppm) if ppm > 0 else math.nan,
        },
        "seconds": {
            "value": float(seconds) / 86400,
            "shown": f"below {bound}" if bound else "a day or more",
        },
    }


def _design_values(results: Results) -> dict[str, Values]:
    """Of the searches for a design, the design, and the fit to its points."""
    screen, design = results.forces("screen"), results.design("two_factor")
    fit = results.fit("two_factor_design")
    judged = results.validation("two_factor_design", "screen")
    found = design[design["origin"] != "augmentation"]
    summary = results.searches()
    scalings, own = summary["scalings"], summary["scaling"]
    patterns = scalings[own]
    counts = "; ".join(
        f"{name}: " + ", ".join(f"{pattern['pattern']} {pattern['count']}" for pattern in each)
        for name, each in sorted(scalings.items(), key=lambda item: item[0] != own)
    )
    excess = max(pattern["objective_excess"] for pattern in patterns)
    errors = results.errors("two_factor_design", "screen")
    least_m = float(errors["hv_m"].min())
    smallest = errors["hv_m"] <= least_m * (1 + 1e-9)
    error = 100 * errors["relative_error"].abs()
    rest_n = _expected_n(fit, h0_m=float(screen["h0_m"].min()), hv_m=0.0)
    return {
        "design_error": {
            "value": 100 * judged["global_error"],
            "fitted": fit.points,
            "judged": round(judged["points"]),
        },
        "sum_of_squares": {
            "value": judged["sum_of_squares"] / results.fit("screen").sum_of_squares
        },
        "patterns": {
            "value": len(patterns),
            "searches": summary["searches"],
            "counts": counts,
            "behind": excess / patterns[0]["objective"],
        },
        "union": {"value": len(found), "extended": len(design)},
        "reduction": {
            "value": len(screen) / len(design),
            "screen": len(screen),
            "design": len(design),
            "saved": len(screen) - len(design),
            "together": len(screen) + len(design),
        },
        "band": {"value": error[~smallest].max()},
        "band_small": {"value": error[smallest].max(), "least_um": 1e6 * least_m},
        "limit": {"value": rest_n, "shown": f"{rest_n:.1e}".replace("e-0", "e-")},
    }


def _extrapolated_values(results: Results) -> dict[str, Values]:
    """Of the forces at the paper's operating point, and what the equation leaves out there."""
    file = "simulations/extrapolation/forces.csv"
    table = results.forces("extrapolation").set_index("point_id")
    point = results.row(table, "operating_point", file)
    wanted = results.row(table, "two_factor_design", file)
    fit = results.fit("two_factor_design")
    expected_n = _expected_n(fit, h0_m=point["h0_m"], hv_m=point["hv_m"])
    file = "simulations/extrapolation/budget.csv"
    columns = ("point_id", "rim_percent", "rim_most_percent", "in_force")
    budgets = results.table(file, *columns).set_index("point_id")
    budget = results.row(budgets, "operating_point", file)
    present = str(budget["in_force"]).split("; ") if pd.notna(budget["in_force"]) else []
    effects = ", ".join(
        f"{name} {budget[f'{name}_percent']:+.1f} %"
        for name in ("inertia", "slip", "heat")
        if name not in present
    )
    included = f"With {' and '.join(present)} in it, which eq. (1) has not; left out are"
    return {
        "model_at_2.2": {
            "value": expected_n,
            "of_ours": 100 * expected_n / point["force_n"],
            **_place(point),
        },
        "simulation_at_2.2": {
            "value": point["force_n"],
            "of_paper": 100 * point["force_n"] / 0.99,
            **_place(point),
            "wanted_um": 1e6 * wanted["hv_m"],
            "wanted_n": wanted["force_n"],
            "equation": included if present else "Eq. (1) leaves out",
            "effects": effects,
            "rim": budget["rim_percent"],
            "rim_most": budget["rim_most_percent"],
            "low": point["force_n"] * (1 + budget["left_out_least_percent"] / 100),
            "high": point["force_n"] * (1 + budget["left_out_most_percent"] / 100),
        },
        "amplitude": {"value": 1e6 * wanted["hv_m"], "force_n": wanted["force_n"]},
    }


def _four_factor_values(results: Results) -> dict[str, Values]:
    """Of the plan, the designs and the fits with four factors.

    locus: largest distance of hv/h0 of an optimum from the nearest of the two-factor design, in
    percent of the largest hv/h0. The model knows h0 and hv by their ratio alone, so that all
    points on a line of equal hv/h0 are as good.
    """
    plan = results.forces("four_factor")
    designs = [results.design(name) for name in ("two_factor", "four_factor")]
    two, four = ((design["hv_m"] / design["h0_m"]).to_numpy() for design in designs)
    distance = np.abs(four[:, None] - two[None, :]).min(axis=1) / two.max()
    judged = results.validation("four_factor_design", "four_factor")
    distinct = results.validation("four_factor_design_distinct", "four_factor")
    control = results.validation("four_factor_design_distinct", "four_factor_control")
    return {
        "four_factor_points": {
            "value": len(plan),
            "positions": len(plan[["phi_r_m", "phi_deg"]].drop_duplicates()),
            "points": len(two),
        },
        "locus": {"value": 100 * distance.max(), "four": _ratios(four), "two": _ratios(two)},
        "four_factor_error": {
            "value": 100 * judged["global_error"],
            "points": len(plan),
            "distinct": 100 * distinct["global_error"],
            "control": 100 * control["global_error"],
            "random": round(control["points"]),
        },
        "four_factor_reduction": {
            "value": len(plan) / len(four),
            "plan": len(plan),
            "design": len(four),
            "saved": len(plan) - len(four),
            "screen": len(results.forces("screen")) + len(two),
        },
    }


def _place(point: pd.Series) -> Values:
    return {"h0_um": 1e6 * point["h0_m"], "hv_um": 1e6 * point["hv_m"]}


def _expected_n(fit: FittedModel, *, h0_m: float, hv_m: float) -> float:
    """The force that a fit expects with the finger centred."""
    return float(fit.force_model.evaluate(fit.theta, Factors.of(h0_m=h0_m, hv_m=hv_m))[0])


def _ratios(values: np.ndarray) -> str:
    return ", ".join(f"{value:.3f}" for value in sorted(set(values.round(3))))
