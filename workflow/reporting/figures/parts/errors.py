"""Errors of a fitted model at control points, for Figure 14 and the error map."""

from pathlib import Path

import pandas as pd

from reporting.figures.parts.tables import micrometres, plane_table
from reporting.pages.notes import percent
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import read_json
from squeezefilm.models.fit_file import number


def error_table(errors: Path, validation: Path, *, layer: str) -> pd.DataFrame:
    """Relative error in percent at each point, and whether it lies in the band."""
    points = read_columns(errors, columns=("h0_m", "hv_m", "relative_error"))
    band = number(read_json(validation), "band", validation)
    return plane_table(points[["h0_m", "hv_m"]], layer=layer).assign(
        relative_error_percent=100 * points["relative_error"],
        in_band=points["relative_error"].abs() <= band,
        band_percent=100 * band,
    )


def error_note(validation: Path, *, fit: str) -> str:
    """The errors over all points in words."""
    summary = read_json(validation)
    values = {
        key: number(summary, key, validation)
        for key in ("points", "global_error", "worst_relative_error", "band", "share_within_band")
    }
    points, share = int(values["points"]), values["share_within_band"]
    outside = points - round(points * share)
    h0_um, hv_um = (
        micrometres(pd.Series([number(summary, key, validation)]))[0]
        for key in ("worst_h0_m", "worst_hv_m")
    )
    inside = "no point" if outside == 0 else f"{outside} points"
    return (
        f"{fit} on {points} control simulations: global error {percent(values['global_error'])}, "
        f"largest relative error {percent(values['worst_relative_error'])} at h0 = {h0_um:g} µm, "
        f"hv = {hv_um:g} µm; {inside} outside ±{100 * values['band']:g} %."
    )
