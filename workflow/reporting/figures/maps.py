"""Maps: the error of the five-point model, the force, and the measured profile."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator

from reporting.figures import parts, style
from reporting.notes import percent, simulations_note
from reporting.results import Results
from squeezefilm.models.data import factors_of

ALONE_MM = 5.0
"""What is shown either way of a single position."""
DECADE = 10.0
"""Forces that span more than this are drawn on a logarithmic scale."""


def error_map(results: Results) -> Figure:
    """Relative error of the model fitted to the design, over the whole space."""
    design = parts.plane_table(results.forces("two_factor_design"), layer="design")
    figure, axes = style.subplots(height_in=3.2)
    filled, lines = parts.error_contours(
        axes, results, bins=14, ticks=(1, 2, 3, 5), colors="0.25", linewidths=0.5
    )
    axes.clabel(lines, fontsize=6, fmt=lambda level: f"{level:g}".replace("-", "−"))
    look: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.7, "zorder": 4}
    parts.dots(axes, design, fill="black", markersize=6, label="design point", **look)
    axes.set(**parts.PLANE)
    figure.colorbar(filled, ax=axes, pad=0.02, label="relative error (%)")
    figure.legend(loc="outside upper center", handletextpad=0.2)
    note = parts.error_note(results, "two_factor_design", "error_map")
    style.add_note(figure, note, simulations_note(results.forces("error_map")), results.beyond)
    return figure


def force_map(results: Results) -> Figure:
    """The force at the centre, and at each position the amplitude for the wanted force."""
    forces = parts.plane_table(results.forces("error_map"), layer="map")
    table = results.table("models/recommended.csv", "space", "model", "h0_m", "force_n")
    table = table[table["model"].notna()]
    wanted_n = results.config["extrapolation"]["force_n"]
    figure, (left, right) = style.subplots(1, 2, wide=True, height_in=3.2)
    figure.set_layout_engine("constrained", w_pad=0.08)  # markers stand over the rim
    _draw_forces(figure, left, forces, wanted_n=wanted_n)
    if table.empty:
        right.set_visible(False)
        note = "(b): no model compared can be judged."
    else:
        anywhere = table[table["space"] == table["space"].iloc[-1]]
        first = anywhere.iloc[0]
        note = (
            f"Wanted: {wanted_n:g} N. (b): h0 = {1e6 * first['h0_m']:g} µm, model "
            f"{first['model']}, {percent(float(first['validation_error']))} off over the "
            f"validation sample, at most {percent(float(first['worst_error']))}."
        )
        _draw_positions(right, anywhere)
    style.add_note(figure, note, results.beyond)
    return figure


def _draw_forces(figure: Figure, axes: Axes, rows: pd.DataFrame, *, wanted_n: float) -> None:
    grid = parts.grid_of(rows, "force_n")
    low, high = float(np.nanmin(grid[2])), float(np.nanmax(grid[2]))
    wide = low > 0 and high > DECADE * low
    ticks = LogLocator(subs=(1, 2, 5)) if wide else MaxNLocator(nbins=12)
    levels = np.asarray(ticks.tick_values(low, high))
    levels = levels[(levels > low / 3) & (levels < 3 * high)]
    norm = "log" if wide else None
    drawn = axes.contourf(*grid, levels=levels, cmap=style.SEQUENTIAL, norm=norm, extend="both")
    axes.contour(*grid, levels=levels, colors="0.3", linewidths=0.3)
    if low < wanted_n < high:
        axes.contour(*grid, levels=[wanted_n], colors="black", linewidths=2.0)
    parts.dots(axes, rows, fill="white", markersize=2.6, markeredgecolor="0.4")
    axes.set(**parts.PLANE, title="(a) force at the centre")
    bar = figure.colorbar(drawn, ax=axes, format="%g", label="mean force (N)")
    bar.ax.minorticks_off()


def _draw_positions(axes: Axes, table: pd.DataFrame) -> None:
    """Amplitudes at positions: hollow where the model is not validated, a cross without any."""
    at = factors_of(table.assign(hv_m=0.0))
    x_mm, y_mm, hv_um = 1e3 * at.x_m, 1e3 * at.y_m, parts.micrometres(table["hv_m"])
    known = np.isfinite(hv_um)
    validated = table["error_95_percent"].notna().to_numpy()
    for chosen, fill in ((known & validated, style.BLUE), (known & ~validated, "white")):
        axes.plot(x_mm[chosen], y_mm[chosen], "o", color=style.BLUE, ms=5, mfc=fill)
    axes.plot(x_mm[~known], y_mm[~known], "x", color=style.VERMILLION)
    for x, y, value in zip(x_mm[known], y_mm[known], hv_um[known], strict=True):
        text = parts.beside(axes, f"{value:.2f}", (x, y), (0, 5), ha="center", fontsize=6)
        text.set_in_layout(False)
    axes.margins(0.15)
    if len(table) == 1:  # nothing else says how large a millimetre is
        axes.set(xlim=(-ALONE_MM, ALONE_MM), ylim=(-ALONE_MM, ALONE_MM))
    axes.set(xlabel="pad's centre, $x$ (mm)", ylabel="$y$ (mm)")
    axes.set_title("(b) amplitude wanted (µm)")
    axes.grid(True)


def profile(results: Results) -> Figure:
    """Amplitude and residual, over the distance from the centre of a disc, or as maps."""
    data = results.table("figures/profile.csv", "layer", "noise_um")
    figure, (amplitude, residual) = style.subplots(1, 2, wide=True, height_in=3.0)
    residual.set_title("(b) what the profile leaves")
    if "map" in set(data["layer"]):
        _draw_profile(figure, amplitude, residual, data)
    else:
        _draw_over_radius(amplitude, residual, data)
    noise = results.summary("profile/summary.json").get("largest_force_noise_fraction")
    note = f"The scan's noise moves a force by up to {noise:.1%} (95 %)." if noise else ""
    style.add_note(figure, note, results.beyond)
    return figure


def _draw_profile(figure: Figure, amplitude: Axes, residual: Axes, data: pd.DataFrame) -> None:
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
    for axes, column, label, limit in (
        (amplitude, "amplitude_um", "amplitude (µm)", float(levels[-1])),
        (residual, "residual_um", "residual (µm)", largest_residual),
    ):
        look: dict[str, Any] = {"cmap": style.DIVERGING, "vmin": -limit, "vmax": limit, "s": 9}
        look |= {"edgecolor": "0.3", "linewidths": 0.3, "clip_on": False}
        drawn = parts.coloured_dots(axes, points, column, x="x_mm", y="y_mm", **look)
        if len(outliers):
            count = f"outliers ({len(outliers)})"
            x, y = outliers["x_mm"], outliers["y_mm"]
            axes.plot(x, y, "x", color=style.VERMILLION, label=count)
            axes.legend(loc="upper right")
        parts.show_grid(axes, grid)
        axes.set(aspect="equal", xlabel="$x$ (mm)", ylabel="$y$ (mm)")
        figure.colorbar(drawn, ax=axes, orientation="horizontal", shrink=0.9, label=label)


def _draw_over_radius(amplitude: Axes, residual: Axes, data: pd.DataFrame) -> None:
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
    r_mm, lowest, highest = (profile[name] for name in ("r_mm", "profile_min_um", "profile_max_um"))
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
    residual.legend(loc="upper right")
