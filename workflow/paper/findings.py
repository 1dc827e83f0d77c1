"""Our value for each of the paper's claims, and what a reader should know of it.

Results have an attribute for each of claims.READERS; forces in N, lengths in m, errors as shares.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace as Results
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import FittedModel
from squeezefilm.models.force_model import get_model

BUDGET_COLUMNS = (
    "point_id",
    "inertia_percent",
    "slip_percent",
    "heat_percent",
    "rim_percent",
    "rim_most_percent",
    "in_force",
    "left_out_least_percent",
    "left_out_most_percent",
)
TIME_BOUNDS = ((1.0, "1 s"), (60.0, "1 min"), (3600.0, "1 h"), (86400.0, "1 day"))

GUESS = (
    "A guess: the paper's marching in time was stopped before the film had settled; "
    "docs/numerics.md tries this and other shortcuts, and none gives all of its numbers"
)


@dataclass(frozen=True)
class Finding:
    """Our value in a claim's unit, how it is shown, and what a reader should know."""

    value: float
    ours: str
    explanation: str = ""


FINDINGS: dict[str, Callable[[Results], Finding]] = {}
"""How our value is found, by the claim's id."""


def finds(claim_id: str) -> Callable[[Callable[[Results], Finding]], Callable[[Results], Finding]]:
    """Put a function into FINDINGS."""
    return lambda function: FINDINGS.setdefault(claim_id, function)


def finding(value: float, form: str = "", explanation: str = "") -> Finding:
    """A finding that is shown as a number in this format."""
    return Finding(float(value), format(value, form), explanation)


@finds("space")
def _space(results: Results) -> Finding:
    h0_um, hv_um = 1e6 * results.screen["h0_m"], 1e6 * results.screen["hv_m"]
    limits = np.array([hv_um.min(), hv_um.max(), h0_um.min(), h0_um.max()])
    return Finding(
        value=float(np.abs(limits - [0.2, 2.0, 5.0, 10.0]).max()),
        ours="hv {:g}–{:g}, h0 {:g}–{:g}".format(*limits.round(6)),
        explanation="Taken from the paper.",
    )


@finds("screen_points")
def _screen_points(results: Results) -> Finding:
    gaps, amplitudes = results.screen["h0_m"].nunique(), results.screen["hv_m"].nunique()
    return finding(
        len(results.screen),
        explanation=f"{gaps} gaps × {amplitudes} amplitudes, our reading of Fig. 7.",
    )


@finds("bounds")
def _bounds(results: Results) -> Finding:
    squares = results.screen_runs["sum_of_squares"]
    bounds = sorted(results.screen_runs["bound"].unique())
    spread = float(squares.max() / squares.min() - 1) if len(bounds) > 1 else math.inf
    shown = "the same" if spread < 1e-6 else f"sum of squares up to {spread:.1g} apart"
    return Finding(
        value=spread,
        ours=shown if len(bounds) > 1 else "one bound only",
        explanation=(
            f"{len(squares)} runs: bounds {', '.join(f'±{bound:g}' for bound in bounds)}; seeds; "
            "differential evolution as a check. The search uses asinh(θ), for with θ itself "
            "GAs often miss the minimum."
        ),
    )


@finds("theta")
def _theta(results: Results) -> Finding:
    theta = results.screen_fit.theta
    largest = max(abs(value) for value in theta)
    return Finding(
        value=math.log10(largest / 10),
        ours=", ".join(f"{value:.4g}" for value in theta).replace("-", "−"),
        explanation="The paper's Table I is not legible to us.",
    )


@finds("screen_error")
def _screen_error(results: Results) -> Finding:
    return finding(_error_percent(results.screen_on_screen), ".3g")


@finds("design_error")
def _design_error(results: Results) -> Finding:
    judged = results.design_on_screen
    return finding(
        _error_percent(judged),
        ".3g",
        f"Fit on {results.design_fit.points} points, judged on {judged['points']}.",
    )


@finds("sum_of_squares")
def _sum_of_squares(results: Results) -> Finding:
    ours = float(results.design_on_screen["sum_of_squares"])
    ratio = ours / results.screen_fit.sum_of_squares
    explanation = "The paper's errors of 4.6 % and 3 % imply (4.6/3)² = 2.35 times."
    return Finding(ratio, f"{ratio:.2f} times", explanation)


@finds("patterns")
def _patterns(results: Results) -> Finding:
    summary = results.design_summary
    own = summary["scaling"]
    counts = "; ".join(
        f"{name}: " + ", ".join(f"{pattern['pattern']} {pattern['count']}" for pattern in patterns)
        for name, patterns in sorted(summary["scalings"].items(), key=lambda item: item[0] != own)
    )
    patterns = summary["scalings"][own]
    behind = max(pattern["objective_excess"] for pattern in patterns) / patterns[0]["objective"]
    return finding(
        len(patterns),
        explanation=(
            f"{summary['searches']} searches each, by unit of the distances in (12), which the "
            f"paper does not state: {counts}. Objectives differ by {behind:.0e} of their value: "
            "the model depends on hv/h0 alone, so only the distances tell points on a line of "
            "equal hv/h0 apart, and how many patterns appear is a matter of that unit."
        ),
    )


@finds("union")
def _union(results: Results) -> Finding:
    found = results.design[results.design["origin"] != "augmentation"]
    extended = f"Extended to {len(results.design)} points by best augmentation."
    return finding(len(found), explanation=extended if len(results.design) > len(found) else "")


@finds("reduction")
def _reduction(results: Results) -> Finding:
    screen, design = len(results.screen), len(results.design)
    return finding(
        screen / design,
        "g",
        explanation=(
            f"{screen} → {design} simulations only where the optimal points are reused, for a "
            f"similar actuator: {screen - design} are saved. The first time θ* needs the {screen} "
            f"as well: {screen + design} in all, and nothing is saved."
        ),
    )


@finds("band")
def _band_elsewhere(results: Results) -> Finding:
    errors = results.design_errors
    elsewhere = errors["hv_m"] > errors["hv_m"].min() * (1 + 1e-9)
    above = "Largest relative error above the screen's smallest amplitude."
    return finding(_worst_percent(errors[elsewhere]), ".2g", above)


@finds("band_small")
def _band_smallest(results: Results) -> Finding:
    errors = results.design_errors
    least_m = errors["hv_m"].min()
    return finding(
        _worst_percent(errors[errors["hv_m"] <= least_m * (1 + 1e-9)]),
        ".2g",
        f"Largest relative error at hv = {1e6 * least_m:g} µm, the screen's smallest. {GUESS}.",
    )


@finds("smallest_force")
def _smallest_force(results: Results) -> Finding:
    row = results.screen.sort_values("force_n", kind="stable").iloc[0]
    ppm = 1e6 * float(row["force_n"])
    needed_um = 1e6 * float(row["hv_m"]) * math.sqrt(90 / ppm) if ppm > 0 else math.nan
    return finding(
        ppm,
        ".4g",
        explanation=(
            f"Smallest force of the screen, at h0 = {1e6 * row['h0_m']:g} µm, "
            f"hv = {1e6 * row['hv_m']:g} µm; small forces go with hv², so 90 ppm would belong to "
            f"hv = {needed_um:.2g} µm. None of the shortcuts "
            "that docs/numerics.md tries gives it."
        ),
    )


@finds("limit")
def _limit(results: Results) -> Finding:
    rest_n = _expected_n(results.design_fit, h0_m=results.screen["h0_m"].min(), hv_m=0.0)
    return Finding(
        value=rest_n,
        ours=f"{rest_n:.1e}".replace("-", "−").replace("e−0", "e−"),
        explanation="By the model the limit is 1 + θ2, which the fit is free to choose.",
    )


def _extrapolated(results: Results, point_id: str) -> pd.Series:
    table = results.extrapolation
    return table[table["point_id"] == point_id].iloc[0]


@finds("model_at_2.2")
def _extrapolated_model(results: Results) -> Finding:
    point = _extrapolated(results, "operating_point")
    force = _expected_n(results.design_fit, h0_m=point["h0_m"], hv_m=point["hv_m"])
    return finding(
        force,
        ".3f",
        f"{_percent_of(force, point['force_n'])} of our simulation at {_place(point)}.",
    )


@finds("simulation_at_2.2")
def _extrapolated_simulation(results: Results) -> Finding:
    point = _extrapolated(results, "operating_point")
    force = float(point["force_n"])
    wanted = _extrapolated(results, "two_factor_design")
    return finding(
        force,
        ".6f",
        explanation=(
            f"At {_place(point)}; {_percent_of(force, 0.99)} of the paper's. The paper's amplitude "
            f"has two digits: at {1e6 * wanted['hv_m']:.3f} µm, where our five-point fit expects "
            f"the wanted force, it is {wanted['force_n']:.3f} N. {_beyond_the_equation(results)} "
            "What else would explain the difference: tables/uncertainty.md."
        ),
    )


def _beyond_the_equation(results: Results) -> str:
    """What the terms that eq. (1) does not have would make of the force at the operating point."""
    table = results.extrapolation_budget
    budget = table[table["point_id"] == "operating_point"].iloc[0]
    force = float(_extrapolated(results, "operating_point")["force_n"])
    low, high = (
        force * (1 + float(budget[f"left_out_{end}_percent"]) / 100) for end in ("least", "most")
    )
    present = str(budget["in_force"]).split("; ") if pd.notna(budget["in_force"]) else []
    effects = ", ".join(
        f"{name} {budget[f'{name}_percent']:+.1f} %"
        for name in ("inertia", "slip", "heat")
        if name not in present
    )
    rim, most = (float(budget[f"rim{end}_percent"]) for end in ("", "_most"))
    said = (
        f"{effects} and, at the rim, {rim:+.1f} to {most:+.1f} % "
        "(first order, simulations/extrapolation/budget.csv): with all of them "
        f"and what higher orders may add {low:.3f} to {high:.3f} N."
    ).replace("-", "−")
    if present:
        return f"With {' and '.join(present)} in it, which eq. (1) has not; left out are {said}"
    return f"Eq. (1) leaves out {said}"


@finds("amplitude")
def _amplitude(results: Results) -> Finding:
    point = _extrapolated(results, "two_factor_design")
    return finding(1e6 * point["hv_m"], ".3f", f"Simulated there: {point['force_n']:.3f} N.")


@finds("four_factor_points")
def _four_factor_points(results: Results) -> Finding:
    plan = results.four_factor
    positions = len(plan[["phi_r_m", "phi_deg"]].drop_duplicates())
    return Finding(
        value=len(plan),
        ours=f"{len(plan)}",
        explanation=f"{positions} positions, our assumption, × {len(results.design)} points.",
    )


@finds("four_factor_error")
def _four_factor_error(results: Results) -> Finding:
    distinct = _error_percent(results.four_factor_distinct_on_plan)
    control = _error_percent(results.four_factor_distinct_on_control)
    return finding(
        _error_percent(results.four_factor_design_on_plan),
        ".1f",
        explanation=(
            f"On the {len(results.four_factor)} simulations; the paper does not state its control "
            f"set. With five physically distinct points: {distinct:.1f} %, and "
            f"{control:.1f} % on {results.four_factor_distinct_on_control['points']} random "
            "control points."
        ),
    )


@finds("locus")
def _locus(results: Results) -> Finding:
    """Largest distance of hv/h0 of a four-factor optimum from the nearest of the two-factor design.

    In proportion to the largest hv/h0. The model knows h0 and hv by their ratio alone, so that all
    points on a line of equal hv/h0 are as good.
    """
    two = (results.design["hv_m"] / results.design["h0_m"]).to_numpy()
    four = (results.four_factor_design["hv_m"] / results.four_factor_design["h0_m"]).to_numpy()
    distance = np.abs(four[:, None] - two[None, :]).min(axis=1) / two.max()
    return finding(
        100 * distance.max(),
        ".1f",
        explanation=(
            "Compared by hv/h0, in which alone the model knows h0 and hv: four factors "
            f"{_ratios(four)}, two factors {_ratios(two)}."
        ),
    )


@finds("four_factor_reduction")
def _four_factor_reduction(results: Results) -> Finding:
    plan, design = len(results.four_factor), len(results.four_factor_design)
    screen = len(results.screen) + len(results.design)
    return finding(
        plan / design,
        "g",
        explanation=(
            f"{plan} → {design} only where the optimal points are reused: {plan - design} are "
            f"saved. The first time θ* needs the {plan} too, on top of {screen} with two factors."
        ),
    )


@finds("seconds")
def _seconds(results: Results) -> Finding:
    slowest = float(results.screen_timings["solve_seconds"].max())
    bound = next((name for limit, name in TIME_BOUNDS if slowest < limit), None)
    return Finding(
        slowest / 86400,
        f"below {bound}" if bound else "a day or more",
        "Wall time of the slowest scene of the screen, its error estimate included.",
    )


def _error_percent(summary: Mapping[str, Any]) -> float:
    return 100 * float(summary["global_error"])


def _worst_percent(errors: pd.DataFrame) -> float:
    return 100 * float(errors["relative_error"].abs().max())


def _expected_n(fit: FittedModel, *, h0_m: float, hv_m: float) -> float:
    """The force that a fit expects with the finger centred."""
    at = Factors.of(h0_m=h0_m, hv_m=hv_m)
    return float(get_model(fit.model).evaluate(fit.theta, at)[0])


def _place(point: pd.Series) -> str:
    return f"h0 = {1e6 * point['h0_m']:g} µm, hv = {1e6 * point['hv_m']:g} µm"


def _percent_of(value: float, reference: float) -> str:
    return f"{100 * value / reference:.1f} %"


def _ratios(values: np.ndarray) -> str:
    return ", ".join(f"{value:.3f}" for value in sorted(set(values.round(3))))
