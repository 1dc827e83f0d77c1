"""Figures 7, 13 and 14: the screen, and the model fitted to the optimal design."""

from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squeezefilm_workflow.reporting.figures import parts, style
from squeezefilm_workflow.reporting.figures.models import model_and_points_figure
from squeezefilm_workflow.reporting.notes import simulation_error_note
from squeezefilm_workflow.reporting.results import Results


def fig07(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The screen: one dot per simulation."""
    screen = results.scenes("screen")
    data = parts.gap_amplitude_table(screen, layer="screen")
    figure, axes = style.subplots()
    parts.draw_dots(axes, data, fill=style.BLUE, markersize=4, markeredgewidth=0.5)
    parts.set_up_gap_amplitude_axes(axes, screen)
    gaps, amplitudes = screen["h0_m"].nunique(), screen["hv_m"].nunique()
    note = f"{len(screen)} simulations: {gaps} gaps × {amplitudes} amplitudes."
    style.add_note(figure, note, results.validity_note)
    return figure, data


def fig13(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The model fitted to the design (mesh, black dots) and the control points (white dots)."""
    fit = results.fit("two_factor_design")
    errors = parts.fit_error_note(results, "two_factor_design", "screen")
    note = f"Fit on {fit.points} points; on {errors}."
    plans = {"control": "screen", "design": "two_factor_design"}
    return model_and_points_figure(results, fit, note, **plans)


def fig14(results: Results) -> tuple[Figure, pd.DataFrame]:
    """Error over amplitude of the fit to the design and of the fit to all points, a panel each."""
    titles = {"two_factor_design": "(a) fit to the design", "screen": "(b) fit to all points"}
    tables = {fit: parts.error_table(results, fit, "screen", layer="control") for fit in titles}
    figure, panels = style.subplots(2, 1, height_in=4.6, sharex=True)
    for axes, (fit, data) in zip(panels, tables.items(), strict=True):
        _draw_errors(axes, data)
        axes.set_title(titles[fit])
        axes.label_outer()
    figure.legend(
        *panels[0].get_legend_handles_labels(),
        loc="outside upper center",
        title=r"mean gap $h_0$ (µm)",
        title_fontsize=7,
        ncols=6,
        handlelength=1.2,
        columnspacing=0.8,
        handletextpad=0.4,
    )
    notes = [f"{titles[fit]}, on {parts.fit_error_note(results, fit, 'screen')}." for fit in titles]
    style.add_note(
        figure, *notes, simulation_error_note(results.forces("screen")), results.validity_note
    )
    by_design, by_all = tables.values()
    return figure, by_design.assign(
        relative_error_all_percent=by_all["relative_error_percent"], in_band_all=by_all["in_band"]
    )


def _draw_errors(axes: Axes, data: pd.DataFrame) -> None:
    """Draw a line for each gap; dots are white inside the band and black outside."""
    band = float(data["band_percent"].iloc[0])
    axes.axhspan(-band, band, color="0.94", zorder=0)
    for edge in (-band, band):
        axes.axhline(edge, color="0.45", linestyle=style.DASHED_LINE, linewidth=0.8)
    axes.axhline(0, color="0.4", linewidth=0.8)
    gaps = np.sort(data["h0_um"].unique())
    colours = mpl.colormaps["viridis"](np.linspace(0, 0.92, len(gaps)))
    x, y = "hv_um", "relative_error_percent"
    for gap, colour in zip(gaps, colours, strict=True):
        line = data[data["h0_um"] == gap].sort_values(x)
        axes.plot(line[x], line[y], color=colour, label=f"{gap:g}", zorder=2)
    look: dict[str, Any] = {"clip_on": True, "zorder": 3}
    # White dots upon one another must not look black.
    for inside, fill, size, rim in ((True, "white", 3.0, "0.5"), (False, "black", 3.6, "black")):
        dots = {"markersize": size, "markeredgecolor": rim, "markeredgewidth": 0.4}
        rows = data[data["in_band"] == inside]
        parts.draw_dots(axes, rows, x=x, y=y, fill=fill, **look, **dots)
    reach = max(1.25 * band, 1.1 * data[y].abs().max())
    axes.set(
        ylim=(-reach, reach),
        xlabel=parts.GAP_AMPLITUDE_LABELS["ylabel"],
        ylabel="relative error (%)",
    )
    look = {"transform": axes.get_yaxis_transform(), "ha": "right", "va": "bottom"}
    for edge, sign in ((band, "+"), (-band, "−")):
        axes.text(0.99, edge, f"{sign}{band:g} % ", fontsize=7, **look)
