"""Figures 7, 8 and 12 to 14: the screen, the optimal design, the models fitted to them."""

from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from reporting.figures import style
from reporting.figures.axes import HV_LABEL, dots, label_points, model_and_points, set_up_plane
from reporting.figures.tables import (
    add_limits,
    error_note,
    error_table,
    model_mesh,
    plane_table,
    simulations_note,
)
from reporting.notes import percent
from reporting.results import Results

AUGMENTATION = "augmentation"


def fig07(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The screen: one dot per simulation."""
    screen = results.scenes("screen")
    data = add_limits(plane_table(screen, layer="screen"), screen)
    figure = style.new_figure()
    axes = figure.subplots()
    dots(axes, data, fill=style.BLUE, markersize=4, markeredgewidth=0.5)
    set_up_plane(axes, data)
    gaps, amplitudes = screen["h0_m"].nunique(), screen["hv_m"].nunique()
    note = f"{len(screen)} simulations: {gaps} gaps × {amplitudes} amplitudes."
    style.add_note(figure, note, results.beyond)
    return figure, data


def fig08(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The model fitted to the screen (mesh) and the simulations (dots)."""
    forces, fit = results.forces("screen"), results.fit("screen")
    data = pd.concat(
        [model_mesh(fit, forces), plane_table(forces, layer="simulation")], ignore_index=True
    )
    note = f"Fit on {fit.points} points: global error {percent(fit.global_error)}."
    looks = {"simulation": {"color": style.VERMILLION, "label": "simulation"}}
    notes = (note, simulations_note(forces), results.beyond)
    return model_and_points(data, looks, notes=notes), data


def fig12(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The design (black, with the letters of its patterns, + if added) on the screen (white)."""
    screen = results.scenes("screen")
    design = results.design("two_factor")
    labels = design["origin"].str.replace(" and ", ", ").replace(AUGMENTATION, "+")
    points = plane_table(design, layer="design").assign(label=labels)
    data = pd.concat([plane_table(screen, layer="screen"), points], ignore_index=True)
    data = add_limits(data, screen)
    figure = style.new_figure()
    axes = figure.subplots()
    label = f"screen, {len(screen)} points"
    white = style.rows(data, "screen")
    dots(axes, white, fill="white", markersize=4, markeredgewidth=0.6, label=label)
    label = f"optimal design, {len(design)} points"
    dots(axes, points, fill="black", markersize=6, label=label)
    set_up_plane(axes, data)
    label_points(axes, points, labels=points["label"])
    figure.legend(loc="outside upper center", ncols=2, handletextpad=0.2)
    note = "Letters: a point's patterns; +: added by best augmentation."
    style.add_note(figure, note, results.beyond)
    return figure, data


def fig13(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The model fitted to the design (mesh, black dots) and the control points (white dots)."""
    design, control = results.forces("two_factor_design"), results.forces("screen")
    fit = results.fit("two_factor_design")
    data = pd.concat(
        [
            model_mesh(fit, control),
            plane_table(control, layer="control"),
            plane_table(design, layer="design"),
        ],
        ignore_index=True,
    )
    looks: dict[str, dict[str, Any]] = {
        "control": {"color": "white", "label": "control point"},
        "design": {"color": "black", "label": "design point", "s": 26},
    }
    note = f"Fit on {fit.points} points; on {error_note(results, 'two_factor_design', 'screen')}."
    notes = (note, simulations_note(design, control), results.beyond)
    return model_and_points(data, looks, notes=notes), data


def fig14(results: Results) -> tuple[Figure, pd.DataFrame]:
    """Error over amplitude, a line per gap; dots white inside the band and black outside."""
    data = error_table(results, "two_factor_design", "screen", layer="control")
    figure = style.new_figure(height_in=2.9)
    axes = figure.subplots()
    band = float(data["band_percent"].iloc[0])
    axes.axhspan(-band, band, color="0.94", zorder=0)
    for edge in (-band, band):
        axes.axhline(edge, color="0.45", linestyle=(0, (4, 2)), linewidth=0.8)
    axes.axhline(0, color="0.6", linewidth=0.6)
    gaps = np.sort(data["h0_um"].unique())
    colours = mpl.colormaps["viridis"](np.linspace(0, 0.92, len(gaps)))
    for gap, colour in zip(gaps, colours, strict=True):
        line = data[data["h0_um"] == gap].sort_values("hv_um")
        axes.plot(
            line["hv_um"], line["relative_error_percent"], color=colour, label=f"{gap:g}", zorder=2
        )
    inside = data["in_band"].astype(bool)
    for chosen, colour in ((inside, "white"), (~inside, "black")):
        axes.plot(
            data["hv_um"][chosen],
            data["relative_error_percent"][chosen],
            "o",
            color=colour,
            markersize=3.6,
            markeredgecolor="black",
            markeredgewidth=0.6,
            zorder=3,
        )
    reach = max(1.25 * band, 1.1 * data["relative_error_percent"].abs().max())
    axes.set_ylim(-reach, reach)
    axes.set_xlabel(HV_LABEL)
    axes.set_ylabel("relative error (%)")
    axes.text(
        0.99,
        band,
        f"±{band:g} % band ",
        transform=axes.get_yaxis_transform(),
        ha="right",
        va="bottom",
        fontsize=7,
    )
    figure.legend(
        loc="outside upper center",
        title=r"mean gap $h_0$ (µm)",
        title_fontsize=7,
        ncols=6,
        handlelength=1.2,
        columnspacing=0.8,
        handletextpad=0.4,
    )
    note = error_note(results, "two_factor_design", "screen")
    style.add_note(figure, note, simulations_note(results.forces("screen")), results.beyond)
    return figure, data
