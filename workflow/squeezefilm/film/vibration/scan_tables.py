"""What a smoothed scan says of itself: a row for each point, and a summary."""

from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.film.vibration.scans import SmoothedScan


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


def summary_of(smoothed: SmoothedScan, *, noise: float, error: float) -> dict[str, Any]:
    """The scan in numbers; shares are of the profile's maximum, or of a force.

    Args:
        noise: largest share of a force that the noise leaves open, at 95 %.
        error: the same with what motion out of phase would do.
    """
    x_m, y_m, weights = smoothed.profile.surface.net()
    standard = smoothed.standard_error(x_m=x_m, y_m=y_m)
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
        "largest_standard_error_share": float(standard.max()),
        "mean_standard_error_share": float(np.average(standard, weights=weights)),
        "peak_bias_share": smoothed.peak_bias_m / smoothed.peak_m,
        "out_of_phase_effect": smoothed.out_of_phase_effect,
        "two_phases": smoothed.two_phases,
        "averaging_loss_share": smoothed.averaging_loss,
        "notes": list(smoothed.scan.notes),
        "signed": smoothed.scan.signed,
        "folded": smoothed.folded,
        "largest_force_noise_share": noise,
        "largest_force_error_share": error,
    }
