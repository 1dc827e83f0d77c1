"""Settings, claims, simulations, fits and numerics of a finished study."""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from reporting.check.quantities import Quantity, column_quantities, guarded, text_of
from reporting.check.tolerances import (
    GIVEN,
    PLACE,
    SAME,
    AtMost,
    Close,
    Closeness,
    Tolerance,
)
from squeezefilm.config.loading import Config
from squeezefilm.io.positions import POLAR, as_in, form_of
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import FACTOR_COLUMNS, read_json, read_ok_forces
from squeezefilm.models.experiments import factors_of
from squeezefilm.models.fitted import number, read_fit
from squeezefilm.models.force_model import get_model

SETTINGS, CLAIMS, SIMULATIONS, FITS, VALIDATION, NUMERICS = (
    "settings",
    "claims",
    "simulations",
    "fits",
    "validation",
    "numerics",
)
PLANS = (
    "screen",
    "two_factor_design",
    "error_map",
    "extrapolation",
    "four_factor",
    "four_factor_control",
    "four_factor_design",
    "four_factor_design_distinct",
)
FIT_NAMES = (
    "screen",
    "two_factor_design",
    "four_factor",
    "four_factor_design",
    "four_factor_design_distinct",
)
OF_THE_PAPER = "four_factor_control"
"""The plan of PLANS that only the paper's studies have."""
PLACED = (
    "two_factor_design",
    "extrapolation",
    "four_factor",
    "four_factor_design",
    "four_factor_design_distinct",
)
"""Plans whose points come out of a design or a fit."""

NOT_DECIDING = {
    *("study", "paper", "numerics", "simulation", "outputs"),
    *("sweep", "models", "comparison", "optimal", "refine"),  # not the paper's
}
"""Sections of a study that decide nothing which is compared."""


def setting_quantities(config: Config) -> Iterator[Quantity]:
    """Every key that decides a result: the study must be the one that the reference is of."""
    for section in (name for name in config if name not in NOT_DECIDING):
        yield Quantity(SETTINGS, section, "keys", dict(_leaves(section, config[section])), SAME)


def _leaves(place: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping):
        for key in sorted(value):
            yield from _leaves(f"{place}.{key}", value[key])
    elif place != "solver.device":  # a study is the same on every device
        yield place, text_of(value)


def claim_quantities(results: Path, closeness: Closeness) -> Iterator[Quantity]:
    """Every claim's verdict and our value; of the run time, the verdict alone."""
    yield from guarded(CLAIMS, "claims.csv", partial(_claims, results / "claims.csv", closeness))


def _claims(path: Path, closeness: Closeness) -> Iterator[Quantity]:
    columns = ("claim_id", "claim", "paper", "ours", "unit", "verdict")
    table = read_columns(path, columns=columns)
    for claim in table.fillna("").astype(str).to_dict("records"):
        agrees = claim["verdict"].partition(" ")[0]
        yield Quantity(CLAIMS, claim["claim_id"], "verdict", {claim["claim"]: agrees}, SAME)
        if claim["claim_id"] != "seconds":
            cells = {f"ours, in {claim['unit']}; paper: {claim['paper']}": claim["ours"]}
            yield Quantity(CLAIMS, claim["claim_id"], "ours", cells, closeness.shown)


def simulation_quantities(
    results: Path, config: Config, closeness: Closeness
) -> Iterator[Quantity]:
    """The points of every plan, their forces, and how their error estimates keep the tolerance."""
    for plan in PLANS:
        if plan == OF_THE_PAPER and not config["paper"]:
            continue
        path = results / "simulations" / plan / "forces.csv"
        yield from guarded(SIMULATIONS, plan, partial(_simulations, plan, path, closeness))


def _simulations(plan: str, path: Path, closeness: Closeness) -> Iterator[Quantity]:
    forces = read_ok_forces(path)
    factors = as_in(FACTOR_COLUMNS, forces)
    shown = forces[["point_id", *factors, "force_n"]]
    tolerances: dict[str, Tolerance] = {
        name: PLACE if plan in PLACED else GIVEN for name in factors
    }
    tolerances["force_n"] = closeness.model if plan in PLACED else closeness.force
    yield from column_quantities(SIMULATIONS, plan, shown, tolerances=tolerances)
    largest = float((forces["force_error_n"] / forces["force_n"].abs()).max())
    yield Quantity(
        SIMULATIONS,
        plan,
        "largest estimated error over the tolerance",
        {"largest of all points": f"{largest / closeness.solver:.3g}"},
        AtMost(1.0),
    )


def fit_quantities(results: Path, config: Config, closeness: Closeness) -> Iterator[Quantity]:
    """Every fit's objective and what it predicts; its parameters loosely; which runs were made."""
    for name in FIT_NAMES:
        yield from guarded(FITS, name, partial(_fit, results / "fits", name, config, closeness))


def _fit(folder: Path, name: str, config: Config, closeness: Closeness) -> Iterator[Quantity]:
    fit = read_fit(folder / f"{name}.json")
    model = get_model(fit.model)
    yield Quantity(
        FITS, name, "objective", {"|y − η|/|y|": f"{fit.global_error:.9g}"}, closeness.residual
    )
    points = _prediction_points(config, positions="phi_r_m" in model.factor_names)
    factors = factors_of(points)
    forces = model.evaluate(fit.theta, factors)
    yield Quantity(
        FITS,
        name,
        "predicted forces",
        dict(zip(_places(points), map(text_of, forces), strict=True)),
        closeness.model,
    )
    yield Quantity(
        FITS,
        name,
        "parameters",
        dict(zip(model.parameter_names, map(text_of, fit.theta), strict=True)),
        closeness.parameters,
    )
    runs = read_columns(folder / f"{name}_runs.csv", columns=("method", "bound", "seed"))
    yield from column_quantities(
        FITS, f"{name}, runs", runs[["method", "bound", "seed"]], tolerances={}
    )


def _prediction_points(config: Config, *, positions: bool) -> pd.DataFrame:
    """Corners, edges and middle of the experiment's space."""

    def three(levels: Mapping[str, float]) -> tuple[float, ...]:
        return levels["start"], (levels["start"] + levels["stop"]) / 2, levels["stop"]

    names = form_of(config["positions"])
    first, second = (max(config["positions"][name]) for name in names)
    places = [(0.0, 0.0), (first, 0.0), (first, second)] if positions else [(0.0, 0.0)]
    rows = [
        (gap, amplitude, *place)
        for gap in three(config["screen"]["h0_m"])
        for amplitude in three(config["screen"]["hv_m"])
        for place in places
    ]
    return pd.DataFrame(rows, columns=["h0_m", "hv_m", *names])


def _places(points: pd.DataFrame) -> list[str]:
    polar = form_of(points) == POLAR
    return [
        f"h0 {1e6 * h0_m:g} µm hv {1e6 * hv_m:g} µm "
        + (
            f"φr {1e3 * first:g} mm φφ {second:g}°"
            if polar
            else f"x {1e3 * first:g} mm y {1e3 * second:g} mm"
        )
        for h0_m, hv_m, first, second in points[as_in(FACTOR_COLUMNS, points)].to_numpy()
    ]


VALIDATIONS = (
    *(
        (fit, plan)
        for fit in ("screen", "two_factor_design")
        for plan in ("screen", "error_map", "extrapolation")
    ),
    *(
        (fit, plan)
        for fit in ("four_factor", "four_factor_design", "four_factor_design_distinct")
        for plan in ("four_factor", OF_THE_PAPER)
    ),
)


def validation_quantities(
    results: Path, config: Config, closeness: Closeness
) -> Iterator[Quantity]:
    """The errors of every fit on every plan."""
    for fit, plan in VALIDATIONS:
        if plan == OF_THE_PAPER and not config["paper"]:
            continue
        path = results / "validation" / f"{fit}_on_{plan}.json"
        yield from guarded(
            VALIDATION,
            path.stem,
            partial(_validation, path, closeness),
        )


def _validation(path: Path, closeness: Closeness) -> Iterator[Quantity]:
    summary = read_json(path)
    points, error = number(summary, "points", path), number(summary, "global_error", path)
    inside = number(summary, "share_within_band", path)
    cells = {"|η − y|/|y|": text_of(error)}
    yield Quantity(VALIDATION, path.stem, "global error", cells, closeness.residual)
    # A point at the very edge of the band may change sides.
    within = {"points": text_of(points), "within the band": text_of(inside * points)}
    yield Quantity(VALIDATION, path.stem, "points", within, Close(absolute=0.01))


def numerics_quantities(results: Path) -> Iterator[Quantity]:
    """The verdict on every stiff or extreme film; none of them may fail."""
    path = results / "numerics" / "stability.csv"
    if path.exists():
        yield from guarded(NUMERICS, "stability", partial(_stability, path))


def _stability(path: Path) -> Iterator[Quantity]:
    table = read_columns(path, columns=("case", "verdict", "reason"))
    verdicts = dict(zip(table["case"].astype(str), table["verdict"].astype(str), strict=True))
    yield Quantity(NUMERICS, "stability", "verdicts", verdicts, SAME)
    failed = sum(verdict == "failed" for verdict in verdicts.values())
    cells = {"number of cases that failed": str(failed)}
    yield Quantity(NUMERICS, "stability", "failed cases", cells, AtMost(0))
