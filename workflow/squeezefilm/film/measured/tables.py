"""A smoothed scan as a table of points and profile, as a summary in numbers, and in words."""

from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.film.measured.rectified import FOLDED
from squeezefilm.film.measured.smooth import SmoothedScan
from squeezefilm.film.surfaces import Disc


def profile_table(smoothed: SmoothedScan) -> pd.DataFrame:
    """The points and what the profile leaves of them, and the profile with its standard error.

    Layers ``points`` and ``outliers``; of a disc ``profile``, the least and largest value over all
    angles and the largest error at each distance from the centre; of a rectangle ``map``.
    """
    surface, micrometres = smoothed.profile.surface, smoothed.peak_m * 1e6
    scan = smoothed.scan
    points = pd.DataFrame(
        {
            "layer": np.where(smoothed.outliers, "outliers", "points"),
            "line": scan.lines,
            "x_mm": scan.x_m * 1e3,
            "y_mm": scan.y_m * 1e3,
            "r_mm": np.hypot(scan.x_m, scan.y_m) * 1e3,
            "amplitude_um": smoothed.measured_m.real * 1e6,
            "residual_um": smoothed.residual_m.real * 1e6,
        }
    )
    x_m, y_m, _ = surface.net()
    profile = smoothed.profile.amplitude(x_m=x_m, y_m=y_m).real * micrometres
    error = smoothed.standard_error(x_m=x_m, y_m=y_m) * micrometres
    if isinstance(surface, Disc):
        drawn = {
            "layer": "profile",
            "r_mm": x_m[:, 0] * 1e3,
            "lowest_um": profile.min(axis=1),
            "highest_um": profile.max(axis=1),
            "error_um": error.max(axis=1),
        }
    else:
        drawn = {
            "layer": "map",
            "x_mm": x_m.ravel() * 1e3,
            "y_mm": y_m.ravel() * 1e3,
            "profile_um": profile.ravel(),
            "error_um": error.ravel(),
        }
    table = pd.concat([points, pd.DataFrame(drawn)], ignore_index=True).round(9)
    return table.astype({"line": "Int64"}).assign(noise_um=round(smoothed.noise_m * 1e6, 9))


def summary_of(smoothed: SmoothedScan, *, noise: float, error: float) -> dict[str, Any]:
    """The scan in numbers; shares are of the profile's maximum, or of a force.

    Args:
        noise: largest share of a force that the noise leaves open, at 95 %.
        error: the same with what motion out of phase would do.
    """
    x_m, y_m, _ = smoothed.profile.surface.net()
    return {
        "points": len(smoothed.measured_m),
        "missing": smoothed.scan.missing,
        "outlier_lines": [int(line) for line in smoothed.scan.lines[smoothed.outliers]],
        "degree": smoothed.degree,
        "peak_um": smoothed.peak_m * 1e6,
        "noise_um": smoothed.noise_m * 1e6,
        "noise_share": smoothed.noise_m / smoothed.peak_m,
        "quadrature_share": smoothed.quadrature,
        "largest_standard_error_share": float(smoothed.standard_error(x_m=x_m, y_m=y_m).max()),
        "peak_bias_share": smoothed.peak_bias_m / smoothed.peak_m,
        "two_phases": smoothed.profile.is_complex,
        "notes": list(smoothed.scan.notes),
        "signed": smoothed.scan.signed,
        "folded": smoothed.folded,
        "largest_force_noise_share": noise,
        "largest_force_error_share": error,
    }


def described(summary: dict[str, Any]) -> str:
    """A summary in words, a line each."""
    outliers = ", ".join(map(str, summary["outlier_lines"][:6]))
    percent = {name: f"{100 * value:.2g} %" for name, value in summary.items() if "share" in name}
    texts = [
        f"points {summary['points']}",
        f"outliers, not fitted {len(summary['outlier_lines'])} (lines {outliers})" * bool(outliers),
        f"degree of the modes {summary['degree']}",
        f"largest amplitude {summary['peak_um']:.4g} µm",
        f"noise {percent['noise_share']} of it",
        f"standard error of the profile {percent['largest_standard_error_share']} of it, at most",
        f"error of a force by the noise {percent['largest_force_noise_share']} at most, at 95 %",
        f"motion out of phase {percent['quadrature_share']} in rms with its noise"
        + ", neglected" * (not summary["two_phases"]),
        "no phase or sign: all amplitudes are taken to one side" * (not summary["signed"]),
        f"warning: {FOLDED}" * summary["folded"],
        *(f"note: {note}" for note in summary["notes"]),
    ]
    return "\n".join(text for text in texts if text)
