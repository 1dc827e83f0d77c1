"""Data of the figure of a measured profile: the points, the profile through them, what is left."""

from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.film.vibration.folds import FOLDED
from squeezefilm.film.vibration.scan_tables import points_table
from squeezefilm.film.vibration.scans import SmoothedScan
from squeezefilm.film.vibration.surfaces import Rectangle

RADII, ANGLES = 81, 72
SIDE = 61
"""Points of the profile's map along each side of a rectangle."""


def build(smoothed: SmoothedScan, summary: dict[str, Any]) -> pd.DataFrame:
    """The points (amplitude, residual), and the profile with its standard error.

    On a disc over the distance from its centre, as its range over angles; on a rectangle as a map.
    Layers points, outliers, and profile or map.
    """
    points = points_table(smoothed)
    flat = isinstance(smoothed.profile.surface, Rectangle)
    place = (
        {"x_mm": points["x_mm"], "y_mm": points["y_mm"]}
        if flat
        else {"r_mm": np.hypot(points["x_mm"], points["y_mm"])}
    )
    measured = pd.DataFrame(
        {
            "layer": np.where(points["outlier"], "outliers", "points"),
            **place,
            "amplitude_um": points["measured_um"],
            "residual_um": points["residual_um"],
        }
    )
    text = note(summary, name=smoothed.scan.path.name, modes=smoothed.profile.surface.modes)
    parts = [measured, _map(smoothed) if flat else _profile(smoothed)]
    return (
        pd.concat(parts, ignore_index=True)
        .round(9)
        .assign(noise_um=round(summary["noise_um"], 9), note=text)
    )


def note(summary: dict[str, Any], *, name: str, modes: str) -> str:
    """The scan and its profile in words."""
    outliers = summary["outlier_lines"]
    lines = ", ".join(map(str, outliers[:6])) + (", …" if len(outliers) > 6 else "")
    word = "line" if len(outliers) == 1 else "lines"
    far = f", {len(outliers)} far from the rest, left out ({word} {lines})" if outliers else ""
    sides = "" if summary["signed"] else " No phase or sign: all amplitudes taken to one side."
    folded = f" WARNING: {FOLDED}." if summary["folded"] else ""
    loss = summary["averaging_loss_share"]
    lost = [f"averaging takes off at most {loss:.1g} of the maximum"] if loss else []
    read = "".join(f" {text[0].upper()}{text[1:]}." for text in (*summary["notes"], *lost))
    across = f"{summary['quadrature_share']:.1%} in rms with its noise"
    if summary["two_phases"]:
        across = f"Motion out of phase: {across}; the profile has it as a second part, not shown."
    else:
        low = f"without it forces are about {summary['out_of_phase_effect']:.2%} low"
        across = f"Motion out of phase, left out: {across}; {low}."
    return (
        f"{name}: {summary['points']} points{far}. {modes} modes up "
        f"to degree {summary['degree']}, by cross-validation. Noise "
        f"{summary['noise_share']:.1%} of the maximum of {summary['peak_um']:.3g} µm, from which "
        f"{summary['peak_bias_share']:.1%} were taken as the noise's; standard error of the "
        f"profile {summary['mean_standard_error_share']:.1%} on average, at most "
        f"{summary['largest_standard_error_share']:.1%}; of a force by the noise, at 95 %, at most "
        f"{summary['largest_force_noise_share']:.1%}. {across}{read}{sides}{folded}"
    )


def _profile(smoothed: SmoothedScan) -> pd.DataFrame:
    """Least and largest profile over all angles at each radius, and the largest standard error."""
    r, phi = np.meshgrid(
        np.linspace(0, smoothed.profile.surface.half_m[0], RADII),
        np.linspace(0, 2 * np.pi, ANGLES, endpoint=False),
        indexing="ij",
    )
    places = {"x_m": r * np.cos(phi), "y_m": r * np.sin(phi)}
    profile = smoothed.profile.amplitude(**places) * smoothed.peak_m * 1e6
    error = smoothed.standard_error(**places) * smoothed.peak_m * 1e6
    return pd.DataFrame(
        {
            "layer": "profile",
            "r_mm": r[:, 0] * 1e3,
            "lowest_um": profile.min(axis=1),
            "highest_um": profile.max(axis=1),
            "error_um": error.max(axis=1),
        }
    )


def _map(smoothed: SmoothedScan) -> pd.DataFrame:
    """The profile and its standard error all over a rectangle."""
    half_x_m, half_y_m = smoothed.profile.surface.half_m
    side = np.linspace(-1, 1, SIDE)
    x_m, y_m = (each.ravel() for each in np.meshgrid(half_x_m * side, half_y_m * side))
    profile = smoothed.profile.amplitude(x_m=x_m, y_m=y_m)
    error = smoothed.standard_error(x_m=x_m, y_m=y_m)
    micrometres = smoothed.peak_m * 1e6
    return pd.DataFrame(
        {
            "layer": "map",
            "x_mm": x_m * 1e3,
            "y_mm": y_m * 1e3,
            "profile_um": profile * micrometres,
            "error_um": error * micrometres,
        }
    )
