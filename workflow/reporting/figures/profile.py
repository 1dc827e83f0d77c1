"""The measured profile and what it does not explain of the scan."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from reporting.figures import parts, style
from reporting.results import Results


def profile(results: Results) -> Figure:
    """Amplitude and residual, over the distance from the centre of a disc, or as maps."""
    data = results.table("figures/profile.csv", "layer", "noise_um")
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=3.0)
    amplitude, residual = figure.subplots(1, 2)
    if "map" in set(data["layer"]):
        _draw_maps(figure, amplitude, residual, data)
    else:
        _draw_lines(amplitude, residual, data)
    noise = results.summary("profile/summary.json").get("largest_force_noise_share")
    note = f"The scan's noise moves a force by up to {noise:.1%} (95 %)." if noise else ""
    style.add_note(figure, note, results.beyond)
    return figure


def _draw_maps(figure: Figure, amplitude: Axes, residual: Axes, data: pd.DataFrame) -> None:
    """The profile's contours with the points' amplitudes; the points' residuals."""
    grid = parts.grid_of(style.rows(data, "map"), "profile_um", x="x_mm", y="y_mm")
    points, noise = style.rows(data, "points"), float(data["noise_um"].iloc[0])
    outliers = style.rows(data, "outliers")
    largest = float(max(np.abs(grid[2]).max(), points["amplitude_um"].abs().max()))
    levels = MaxNLocator(nbins=16, symmetric=True).tick_values(-largest, largest)
    largest_residual = float(max(3 * noise, points["residual_um"].abs().max()))
    amplitude.contourf(*grid, levels=levels, cmap=style.DIVERGING)
    amplitude.contour(*grid, levels=[0.0], colors="black", linewidths=1.6)
    amplitude.set_title("(a) measured (dots) and smoothed")
    residual.set_title("(b) what the profile leaves")
    for axes, column, label, limit in (
        (amplitude, "amplitude_um", "amplitude (µm)", float(levels[-1])),
        (residual, "residual_um", "residual (µm)", largest_residual),
    ):
        look: dict[str, Any] = {"cmap": style.DIVERGING, "vmin": -limit, "vmax": limit, "s": 9}
        look |= {"edgecolor": "0.3", "linewidths": 0.3, "clip_on": False}
        drawn = parts.coloured_dots(axes, points, column, x="x_mm", y="y_mm", **look)
        if len(outliers):
            count = f"outliers ({len(outliers)})"
            axes.plot(
                *outliers[["x_mm", "y_mm"]].to_numpy().T, "x", color=style.VERMILLION, label=count
            )
            axes.legend(loc="upper right")
        parts.show_grid(axes, grid)
        axes.set(aspect="equal", xlabel="$x$ (mm)", ylabel="$y$ (mm)")
        figure.colorbar(drawn, ax=axes, orientation="horizontal", shrink=0.9, label=label)


def _draw_lines(amplitude: Axes, residual: Axes, data: pd.DataFrame) -> None:
    """Amplitude and residual over the distance from the centre."""
    profile, noise = style.rows(data, "profile"), float(data["noise_um"].iloc[0])
    for axes, column in ((amplitude, "amplitude_um"), (residual, "residual_um")):
        for layer, colour in (("points", style.BLUE), ("outliers", style.VERMILLION)):
            points = style.rows(data, layer)
            if len(points):
                x, y, label = points["r_mm"], points[column], f"{layer} ({len(points)})"
                axes.plot(x, y, ".", color=colour, markersize=2.5, label=label)
        axes.axhline(0, color="black", linewidth=0.6)
        axes.set_xlabel("distance from the centre $r$ (mm)")
        axes.set_xlim(0, 1.02 * float(profile["r_mm"].max()))
    r_mm, lowest, highest = (profile[name] for name in ("r_mm", "lowest_um", "highest_um"))
    names = ("range ± 2 st. errors", "profile, least and largest")
    if lowest.equals(highest):
        names = ("± 2 standard errors", "profile")
    band = (lowest - 2 * profile["error_um"], highest + 2 * profile["error_um"])
    look: dict[str, Any] = {"color": style.ORANGE, "alpha": 0.4, "linewidth": 0}
    amplitude.fill_between(r_mm, *band, label=names[0], **look)
    amplitude.plot(r_mm, highest, color="black", label=names[1])
    amplitude.plot(r_mm, lowest, color="black")
    amplitude.set(title="(a) measured and smoothed", ylabel="amplitude (µm)")
    amplitude.legend(loc="upper right")
    residual.axhspan(-2 * noise, 2 * noise, color="0.9", zorder=0, label="± 2 σ of the noise")
    reach = max(3.5 * noise, 1.3 * float(data["residual_um"].abs().max()))
    residual.set(ylim=(-reach, 1.25 * reach), ylabel="residual (µm)")
    residual.set_title("(b) what the profile leaves")
    residual.legend(loc="upper right")
