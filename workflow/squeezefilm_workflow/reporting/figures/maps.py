"""Maps: error of the five-point model, force, amplitude for a force, and the profile."""

from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator

from squeezefilm.models.data import factors_of_table
from squeezefilm_workflow.reporting.figures import parts, style
from squeezefilm_workflow.reporting.notes import (
    bound_percent_text,
    percent_text,
    signed_text,
    simulation_error_note,
)
from squeezefilm_workflow.reporting.results import Results

MIN_LOG_SCALE_RATIO = 10.0
"""Forces that span more than this are drawn on a logarithmic scale."""
MAX_POINTS_WITH_MARKERS = 100
"""Simulations of a map, at most, that are drawn as dots."""
MARKER_OF_STATUS = {"validated": "o", "not validated": "s", "no amplitude": "X"}
"""Of positions: whether a model has an amplitude there, and whether it is validated."""
REQUIRED_PROFILE_COLUMNS = ("layer", "amplitude_um", "residual_um", "noise_um")
"""Of a table of a profile, among others."""
MAP_POINTS_PER_AXIS = 101
"""Of the grid along each side on which a vibration is drawn."""


def error_map(results: Results) -> Figure:
    """Relative error of the model fitted to the design, over the whole space."""
    design = parts.gap_amplitude_table(results.forces("two_factor_design"), layer="design")
    figure, axes = style.subplots(height_in=3.2)
    filled, lines = parts.draw_error_contours(
        axes, results, bins=14, ticks=(1, 2, 3, 5), colors="0.25", linewidths=0.5
    )
    parts.label_contours(axes, lines, partial(signed_text, digits=3))
    look: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.7, "zorder": 4}
    parts.draw_dots(axes, design, fill="black", markersize=6, label="design point", **look)
    axes.set(**parts.GAP_AMPLITUDE_LABELS)
    figure.colorbar(filled, ax=axes, pad=0.02, label="relative error (%)")
    figure.legend(loc="outside upper center", ncols=2, handletextpad=0.4)
    simulated = results.forces("error_map")
    notes = parts.interpolation_note(simulated), simulation_error_note(simulated)
    note = parts.fit_error_note(results, "two_factor_design", "error_map")
    style.add_note(figure, f"Fit on the design; on {note}.", *notes, results.validity_note)
    return figure


def forces(results: Results) -> Figure:
    """Mean force with the pad centred over gap and amplitude; the target force is a thick line."""
    rows = parts.gap_amplitude_table(results.forces("error_map"), layer="map")
    target_n = results.config.extrapolation.force_n
    grid = parts.grid_arrays_of_table(rows, "force_n")
    low, high = float(np.nanmin(grid[2])), float(np.nanmax(grid[2]))
    wide = low > 0 and high > MIN_LOG_SCALE_RATIO * low
    ends = (low / 3, 3 * high) if wide else (low, high)
    ticks = LogLocator(subs=(1, 2, 5)) if wide else MaxNLocator(nbins=12)
    levels = np.asarray(ticks.tick_values(*ends))
    first, last = np.searchsorted(levels, [low, high])
    levels = levels[max(first - 1, 0) : last + 1]
    figure, axes = style.subplots(height_in=3.2)
    figure.set_layout_engine("constrained", w_pad=0.08)  # markers stand over the rim
    norm = "log" if wide else None
    drawn = axes.contourf(*grid, levels=levels, cmap=style.SEQUENTIAL_COLOURMAP, norm=norm)
    axes.contour(*grid, levels=levels, colors="0.3", linewidths=0.3)
    if len(rows) <= MAX_POINTS_WITH_MARKERS:
        parts.draw_dots(axes, rows, fill="white", markersize=2.6, markeredgecolor="0.4")
    parts.limit_axes_to_grid(axes, grid)
    axes.set(**parts.GAP_AMPLITUDE_LABELS)
    bar = figure.colorbar(drawn, ax=axes, pad=0.02, format="%g", label="mean force (N)")
    bar.ax.minorticks_off()
    if low < target_n < high:
        axes.contour(*grid, levels=[target_n], colors="black", linewidths=2.0)
        axes.plot([], [], "k", linewidth=2.0, label=f"target force, {target_n:g} N")
        figure.legend(loc="outside upper center")
    notes = parts.interpolation_note(rows), simulation_error_note(results.forces("error_map"))
    style.add_note(figure, *notes, results.validity_note)
    return figure


def amplitudes(results: Results) -> Figure:
    """Amplitude for the target force at each position, by the recommended model.

    A square where the model is not validated, a white cross where no amplitude gives the force.
    """
    table = results.table("models/recommended.csv", "space", "model", "h0_m", "force_n")
    table = table[table["model"].notna()]
    figure, axes = style.subplots(height_in=3.2)
    if table.empty:
        parts.write_not_known(axes)
        return figure
    table = table[table["space"] == table["space"].iloc[-1]]
    at = factors_of_table(table.assign(hv_m=0.0))
    rows = pd.DataFrame({"x_mm": 1e3 * at.x_m, "y_mm": 1e3 * at.y_m})
    rows["hv_um"] = parts.metres_to_micrometres(table["hv_m"])
    known, validated = rows["hv_um"].notna(), table["error_95_percent"].notna()
    rows["mark"] = np.select([~known, validated], ["no amplitude", "validated"], "not validated")
    norm, cmap = Normalize(), mpl.colormaps[style.SEQUENTIAL_COLOURMAP].with_extremes(bad="white")
    norm.autoscale_None(rows.loc[known, "hv_um"])
    look: dict[str, Any] = {"norm": norm, "cmap": cmap, "plotnonfinite": True, "s": 26}
    look |= {"edgecolors": "black", "linewidths": 0.6, "x": "x_mm", "y": "y_mm"}
    for mark, rows_marked in rows.groupby("mark"):
        look |= {"marker": MARKER_OF_STATUS[str(mark)], "label": mark}
        dots = parts.draw_coloured_dots(axes, rows_marked, "hv_um", **look)
    if known.any():
        figure.colorbar(dots, ax=axes, pad=0.02, label=parts.GAP_AMPLITUDE_LABELS["ylabel"])
    axes.margins(0.15)
    axes.set(xlabel="pad's centre, $x$ (mm)", ylabel="pad's centre, $y$ (mm)")
    axes.grid(True)
    legend = figure.legend(loc="outside upper center", ncols=3, handletextpad=0.2)
    for handle in legend.legend_handles:  # of marks: a colour is that of an amplitude
        if isinstance(handle, Collection):
            handle.set_array(None)
            handle.set_facecolor("white")
    first = table.iloc[0]
    where = f"{first['force_n']:g} N at h0 = {1e6 * first['h0_m']:g} µm"
    errors = f"Largest error of the model: {percent_text(float(first['worst_error']))}."
    style.add_note(figure, f"By {first['model']} for {where}.", errors, results.validity_note)
    return figure


def vibration(results: Results) -> Figure:
    """Vibration over the surface as a fraction of its maximum, with its sign, and the pad."""
    surface, pad = results.config.actuator.surface, results.config.read_pad()
    x_m, y_m = np.meshgrid(
        *(np.linspace(-half, half, MAP_POINTS_PER_AXIS) for half in surface.half_extents_m)
    )
    s = results.config.read_profile().amplitude(x_m=x_m, y_m=y_m)
    s = np.clip(np.abs(s) if np.iscomplexobj(s) else s, -1.0, 1.0)
    figure, axes = style.subplots(height_in=3.2)
    signed_profile = bool((s < 0).any())
    cmap = style.DIVERGING_COLOURMAP if signed_profile else style.SEQUENTIAL_COLOURMAP
    levels = np.linspace(-1 if signed_profile else 0, 1, 21)
    filled = axes.contourf(1e3 * x_m, 1e3 * y_m, s, levels=levels, cmap=cmap)
    if signed_profile:
        axes.contour(1e3 * x_m, 1e3 * y_m, s, levels=[0], colors="0.35", linewidths=0.5)
    outside = surface.relative_distance(x_m, y_m)
    axes.contourf(1e3 * x_m, 1e3 * y_m, outside, levels=(1, 2), colors="white")
    edge_mm = 1e3 * pad.edge_points_m()
    axes.fill(*edge_mm.T, fill=False, edgecolor="black", linewidth=1.8, label="pad, centred")
    axes.set(aspect="equal", xlabel="$x$ (mm)", ylabel="$y$ (mm)")
    label = "amplitude over its maximum (–)"
    figure.colorbar(filled, ax=axes, shrink=0.8, pad=0.02, label=label)
    figure.legend(loc="outside upper center")
    note = "Colours: interpolated linearly between computed points."
    sign = " Negative: opposite phase; thin grey line: no vibration." if signed_profile else ""
    style.add_note(figure, f"Surface: {surface.text}.{sign}", note, results.validity_note)
    return figure


def profile(results: Results) -> Figure:
    """Amplitude and residual, over the distance from the centre of a disc, or as maps."""
    data = results.table("figures/profile.csv", *REQUIRED_PROFILE_COLUMNS)
    noise = results.read_json_file("profile/summary.json").get("largest_force_noise_fraction")
    note = (
        f"Measurement noise of the scan: up to {bound_percent_text(noise)} of a force (95 %)."
        if noise
        else ""
    )
    return draw_profile_table(data, note, results.validity_note)


def draw_profile_table(data: pd.DataFrame, *notes: str) -> Figure:
    """The same of a table that ``squeezefilm profile`` wrote."""
    figure, (amplitude, residual) = style.subplots(1, 2, wide=True, height_in=3.0)
    residual.set_title("(b) residuals")
    if "map" in set(data["layer"]):
        _draw_profile(figure, amplitude, residual, data)
    else:
        _draw_over_radius(amplitude, residual, data)
    style.add_note(figure, *notes)
    return figure


def _draw_profile(figure: Figure, amplitude: Axes, residual: Axes, data: pd.DataFrame) -> None:
    """The profile's contours with the points' amplitudes; the points' residuals."""
    grid = parts.grid_arrays_of_table(
        style.layer_rows(data, "map"), "profile_um", x="x_mm", y="y_mm"
    )
    points, noise = style.layer_rows(data, "points"), float(data["noise_um"].iloc[0])
    outliers = style.layer_rows(data, "outliers")
    largest = float(max(np.abs(grid[2]).max(), points["amplitude_um"].abs().max()))
    levels = MaxNLocator(nbins=16, symmetric=True).tick_values(-largest, largest)
    largest_residual = float(max(3 * noise, points["residual_um"].abs().max()))
    amplitude.contourf(*grid, levels=levels, cmap=style.DIVERGING_COLOURMAP)
    amplitude.contour(*grid, levels=[0.0], colors="black", linewidths=1.6)
    amplitude.set_title("(a) measured (dots) and smoothed")
    for axes, column, label, limit in (
        (amplitude, "amplitude_um", "amplitude (µm)", float(levels[-1])),
        (residual, "residual_um", "residual (µm)", largest_residual),
    ):
        look: dict[str, Any] = {
            "cmap": style.DIVERGING_COLOURMAP,
            "vmin": -limit,
            "vmax": limit,
            "s": 9,
        }
        look |= {"edgecolor": "0.3", "linewidths": 0.3, "clip_on": False}
        drawn = parts.draw_coloured_dots(axes, points, column, x="x_mm", y="y_mm", **look)
        if len(outliers):
            marks = axes.plot(outliers["x_mm"], outliers["y_mm"], "x", color=style.VERMILLION)
        parts.limit_axes_to_grid(axes, grid)
        axes.set(aspect="equal", xlabel="$x$ (mm)", ylabel="$y$ (mm)")
        figure.colorbar(drawn, ax=axes, orientation="horizontal", shrink=0.9, label=label)
    if len(outliers):
        figure.legend(marks, [f"outliers ({len(outliers)})"], loc="outside upper center")


def _draw_over_radius(amplitude: Axes, residual: Axes, data: pd.DataFrame) -> None:
    """Amplitude and residual over the distance from the centre; triangles: outliers beyond."""
    profile, noise = style.layer_rows(data, "profile"), float(data["noise_um"].iloc[0])
    fitted = style.layer_rows(data, "points")
    height = 1.2 * max(fitted["amplitude_um"].abs().max(), profile["profile_max_um"].abs().max())
    reach = max(3.5 * noise, 1.3 * float(fitted["residual_um"].abs().max()))
    for axes, column, limit in (
        (amplitude, "amplitude_um", height),
        (residual, "residual_um", reach),
    ):
        for layer, colour in (("points", style.BLUE), ("outliers", style.VERMILLION)):
            points = style.layer_rows(data, layer)
            if len(points):
                _draw_points_within(axes, points, column, limit=limit, color=colour)
        axes.axhline(0, color="black", linewidth=0.6)
        axes.set_xlabel("distance from the centre $r$ (mm)")
        axes.set_xlim(0, 1.02 * float(profile["r_mm"].max()))
    r_mm, lowest, highest = (profile[name] for name in ("r_mm", "profile_min_um", "profile_max_um"))
    names = ("range ± 2 standard errors", "profile, least and largest")
    if lowest.equals(highest):
        names = ("± 2 standard errors", "profile")
    band = (lowest - 2 * profile["error_um"], highest + 2 * profile["error_um"])
    amplitude.fill_between(r_mm, *band, label=names[0], color=style.ORANGE, alpha=0.4, linewidth=0)
    amplitude.plot(r_mm, highest, color="black", label=names[1])
    amplitude.plot(r_mm, lowest, color="black")
    amplitude.set(title="(a) measured and smoothed", ylabel="amplitude (µm)")
    amplitude.set_ylim(*np.clip(amplitude.get_ylim(), -height, height))
    residual.axhspan(-2 * noise, 2 * noise, color="0.9", zorder=0, label="± 2 σ of the noise")
    residual.set(ylim=(-reach, reach), ylabel="residual (µm)")
    for axes in (amplitude, residual):
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=2)


def _draw_points_within(
    axes: Axes, points: pd.DataFrame, column: str, *, limit: float, color: str
) -> None:
    """Points of a layer over the radius, with their number; triangles at the limits: beyond."""
    r_mm, beyond = points["r_mm"], points[column].abs() > limit
    look: dict[str, Any] = {"color": color, "linestyle": "none"}
    label = f"{points['layer'].iloc[0]} ({len(points)})"
    axes.plot(r_mm[~beyond], points[column][~beyond], marker=".", ms=2.5, label=label, **look)
    look |= {"ms": 4, "clip_on": False, "label": f"{beyond.sum()} beyond the axis"}
    for edge, marker in ((limit, "^"), (-limit, "v")):
        if len(at := r_mm[beyond & (points[column] * edge > 0)]):
            axes.plot(at, 0 * at + edge, marker=marker, **look)
            look["label"] = ""
