"""Measured profile: the measured profile and its residuals.

The measured amplitudes and the smooth profile that all simulations use, over the distance from the
disc's centre; where the profile is not axisymmetric, its least and largest value at that distance.
The band adds two standard errors to that range. On the right what the profile does not explain.
Forces of this study are uncertain by the scan's noise too: the note says by how much at most, at 95
%. The errors in tables of forces are the solver's alone.
"""

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import style

INPUTS = {
    "table": "figures/profile.csv",
}


def draw(data: pd.DataFrame) -> Figure:
    """Amplitude and residual over the distance from the centre.

    Layers points, outliers and profile.
    """
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=3.0)
    amplitude, residual = figure.subplots(1, 2)
    profile, noise = style.rows(data, "profile"), float(data["noise_um"].iloc[0])
    for axes, column in ((amplitude, "amplitude_um"), (residual, "residual_um")):
        for layer, colour in (("points", style.BLUE), ("outliers", style.VERMILLION)):
            points = style.rows(data, layer)
            if len(points):
                label = f"{layer} ({len(points)})"
                axes.plot(
                    points["r_mm"], points[column], ".", color=colour, markersize=2.5, label=label
                )
        axes.axhline(0, color="black", linewidth=0.6)
        axes.set_xlabel("distance from the centre $r$ (mm)")
        axes.set_xlim(0, 1.02 * float(profile["r_mm"].max()))
    angles = not profile["lowest_um"].equals(profile["highest_um"])
    lowest, highest, error = (profile[name] for name in ("lowest_um", "highest_um", "error_um"))
    amplitude.fill_between(
        profile["r_mm"],
        lowest - 2 * error,
        highest + 2 * error,
        color=style.ORANGE,
        alpha=0.4,
        linewidth=0,
        label="range ± 2 st. errors" if angles else "± 2 standard errors",
    )
    amplitude.plot(
        profile["r_mm"],
        highest,
        color="black",
        label="profile, least and largest" if angles else "profile",
    )
    amplitude.plot(profile["r_mm"], lowest, color="black")
    amplitude.set_ylabel("amplitude (µm)")
    amplitude.set_title("(a) measured and smoothed")
    amplitude.legend(loc="upper right")
    residual.axhspan(-2 * noise, 2 * noise, color="0.9", zorder=0, label="± 2 σ of the noise")
    reach = max(3.5 * noise, 1.3 * float(data["residual_um"].abs().max()))
    residual.set_ylim(-reach, 1.25 * reach)
    residual.set_ylabel("residual (µm)")
    residual.set_title("(b) what the profile leaves")
    residual.legend(loc="upper right")
    style.add_note(figure, data)
    return figure
