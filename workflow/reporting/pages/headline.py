"""What a study found, in a few lines of Markdown: what its page and its report begin with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reporting.pages.notes import Inertia, percent
from squeezefilm.io.markdown import markdown_table
from squeezefilm.io.positions import form_of
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import read_json
from squeezefilm.units import to_its_error, with_error

IN_SHORT = "## In short"
WORDS = {"two_factor": "with the finger at the centre", "four_factor": "with the finger anywhere"}
PLACES = {"phi_r_m": ("φr (mm)", 1e3), "phi_deg": ("φφ (°)", 1.0)} | {
    f"{axis}_m": (f"{axis} (mm)", 1e3) for axis in "xy"
}


def in_short(results: Path, config: Mapping[str, Any]) -> list[str]:
    """The lines, from a study's results; ``config`` has paper, gas, actuator, screen, validation.

    Of another study than the paper's also the recommended models and their amplitudes.
    """
    found = [*_force(results), *_model(results), *_claims(results / "claims.csv")]
    amplitudes: list[str] = []
    recommended = results / "models" / "recommended.csv"
    if not config["paper"] and recommended.exists():
        table = read_columns(recommended, columns=("space", "model", "validation_error", "force_n"))
        table = table[table["model"].notna()]
        band = config["validation"]["relative_error_band"]
        found += [
            _recommended(rows.iloc[0], band=band) for _, rows in table.groupby("space", sort=False)
        ]
        amplitudes = list(_amplitudes(table)) if len(table) else []
        if table.empty:
            found.append("No model compared can be judged; the pages of models say why")
    found += _left_out(results / "simulations" / "screen" / "budget.csv")
    found += filter(None, [Inertia.of(config).note(config["screen"]["h0_m"]["stop"])])
    return [f"{IN_SHORT}\n", "".join(f"- {line}\n" for line in found), *amplitudes]


def _force(results: Path) -> Iterator[str]:
    """That at the operating point, beyond the screen."""
    forces = results / "simulations" / "extrapolation" / "forces.csv"
    if not forces.exists():
        return
    table = read_columns(forces, columns=("point_id", "status", "force_n", "force_error_n"))
    scan = results / "profile" / "summary.json"
    noise = read_json(scan).get("largest_force_noise_share") if scan.exists() else None
    more = f", the solver's error; the scan's noise: up to {noise:.1%} more" if noise else ""
    solved = (table["point_id"] == "operating_point") & (table["status"] == "ok")
    for row in table[solved].to_dict("records"):
        h0, hv = (1e6 * row[name] for name in ("h0_m", "hv_m"))
        force = with_error(row["force_n"], row["force_error_n"])
        yield f"F(h0 = {h0:g} µm, hv = {hv:g} µm, finger centred) = {force}{more}"


def _model(results: Path) -> Iterator[str]:
    """How far off the fit to the five-point design is."""
    validation = results / "validation" / "two_factor_design_on_screen.json"
    fit = results / "fits" / "two_factor_design.json"
    if validation.exists() and fit.exists():
        summary = read_json(validation)
        yield (
            f"The model fitted to {read_json(fit)['points']:.0f} points is "
            f"{100 * summary['global_error']:.2g} % off over the {summary['points']:.0f} points "
            "of the screen"
        )


def _claims(claims: Path) -> Iterator[str]:
    """How many of the paper's agree."""
    if claims.exists():
        agrees = read_columns(claims, columns=("verdict",))["verdict"].str.startswith("agrees")
        yield f"{agrees.sum()} of {len(agrees)} claims of the paper agree"


def _recommended(row: pd.Series, *, band: float) -> str:
    """A space's best model, its error, and whether it holds the study's band."""
    said = (
        f"Best model {WORDS[row['space']]}: {row['model']}, {percent(row['validation_error'])} off "
        f"over {row['validation_points']:.0f} points of the validation sample, at one of all "
        f"{row['simulations']:.0f} simulations there {percent(row['worst_error'])}"
    )
    if row["worst_error"] <= band:
        return said
    return (
        f"{said}. No model compared holds the study's ±{100 * band:g} % everywhere: simulate, or "
        "add a formula (section `models`)"
    )


def _amplitudes(table: pd.DataFrame) -> Iterator[str]:
    """For the wanted force, at each position."""
    first, names = table.iloc[0], form_of(table)
    yield (
        f"Amplitude for {first['force_n']:g} N at h0 = {1e6 * first['h0_m']:g} µm, by models; "
        "the error is that of the force which 95 % of points of the declared space do not exceed:\n"
    )
    rows = []
    for row in table.to_dict("records"):
        hv_um = 1e6 * row["hv_m"]
        shown, _ = to_its_error(hv_um, 1e6 * row["hv_error_95_m"])
        error = row["error_95_percent"]
        rows.append(
            {
                "model": row["model"],
                **{PLACES[name][0]: f"{PLACES[name][1] * row[name]:g}" for name in names},
                "hv (µm)": shown if np.isfinite(hv_um) else "none",
                "95 % error": f"{error:.2g} %" if np.isfinite(error) else str(row["note"]),
            }
        )
    yield markdown_table(pd.DataFrame(rows))


def _left_out(budget: Path) -> list[str]:
    """What the film equation leaves out of the screen's forces, in all."""
    if not budget.exists():
        return []
    table = read_columns(budget, columns=("left_out_least_percent", "left_out_most_percent"))
    ends = table[["left_out_least_percent", "left_out_most_percent"]].to_numpy(dtype=float)
    if not np.isfinite(ends).all():
        return ["What the film equation leaves out of the forces is not known everywhere"]
    above = table["above_range"].fillna("").ne("").any()
    caveat = "; somewhere too large for a first order" if above else ""
    least, most = (f"{end:+.2g}".replace("-", "−") for end in (ends.min(), ends.max()))
    return [
        "With the finger centred the film equation leaves out effects that change a force by "
        f"{least} to {most} % in all (first order and what higher ones may add{caveat}); "
        "no other error contains that"
    ]
