"""What a smoothed scan says of itself: a row for each point, and a summary."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.profiles.scans import SmoothedScan


def points_table(smoothed: SmoothedScan) -> pd.DataFrame:
    """Measured points, the profile there with its standard error, and what is left between."""
    error = smoothed.standard_error(x_m=smoothed.x_m, y_m=smoothed.y_m)
    micrometres = 1e6
    return pd.DataFrame(
        {
            "line": smoothed.scan.lines,
            "x_mm": smoothed.x_m * 1e3,
            "y_mm": smoothed.y_m * 1e3,
            "measured_um": smoothed.measured_m * micrometres,
            "profile_um": (smoothed.measured_m - smoothed.residual_m) * micrometres,
            "residual_um": smoothed.residual_m * micrometres,
            "standard_error_um": error * smoothed.peak_m * micrometres,
            "outlier": smoothed.outliers,
        }
    )


def summary_of(smoothed: SmoothedScan, *, spread: float) -> dict[str, Any]:
    """The scan in numbers; shares are of the profile's maximum.

    Args:
        spread: largest relative standard deviation of a force by the noise.
    """
    radius_m = np.linspace(0, smoothed.profile.surface_radius_m, 41)
    angle = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    r, phi = np.meshgrid(radius_m, angle, indexing="ij")
    error = smoothed.standard_error(x_m=r * np.cos(phi), y_m=r * np.sin(phi))
    return {
        "points": len(smoothed.measured_m),
        "missing": smoothed.scan.missing,
        "outlier_lines": [int(line) for line in smoothed.scan.lines[smoothed.outliers]],
        "degree": smoothed.degree,
        "modes": len(smoothed.profile.coefficients),
        "peak_um": smoothed.peak_m * 1e6,
        "noise_um": smoothed.noise_m * 1e6,
        "noise_share": smoothed.noise_m / smoothed.peak_m,
        "cross_validation_share": smoothed.scores[smoothed.degree] / smoothed.peak_m,
        "quadrature_share": smoothed.quadrature,
        "largest_standard_error_share": float(error.max()),
        "mean_standard_error_share": float(np.average(error, weights=r + 1e-30)),
        "largest_force_noise_share": spread,
    }
