"""The whole study at a glance: a film, the model, its design, its error."""

from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from squeezefilm_workflow.reporting.figures import parts, style
from squeezefilm_workflow.reporting.notes import percent_text, rounded_up_text
from squeezefilm_workflow.reporting.results import Results

FILM_COLUMNS = ("phase_deg", "x_mm", "surface_um", "pad_um", "gauge_pressure_kpa")
# Two rows: on a phone, letters are as large as those of the text around.
PANEL_LEFT_EDGES, PANEL_WIDTHS = (0.13, 0.62, 0.13, 0.62), (0.33, 0.36, 0.33, 0.2)
"""Left edge and width of each step's axes, as shares of the figure's width."""
HEADING_HEIGHT = 0.095
"""Height of a step's heading, and in the row's bottom that of labels, as shares of the figure's."""
LABELS_HEIGHT = 0.08
PanelRectangle = tuple[float, float, float, float]
"""Left, bottom, width and height, as shares of the figure's."""
LABEL_FONT_SIZE, TICK_FONT_SIZE = 6.5, 6
DOT_STYLE: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.6, "zorder": 4}
GAP_AXIS_LABELS = (r"gap $h_0$ (µm)", r"amplitude $h_v$ (µm)")


def overview(results: Results) -> Figure:
    """Simulate, fit, design, validate: a step each, with what came of it above."""
    film = results.table("simulations/extrapolation/film.csv", "point_id", *FILM_COLUMNS)
    film = film[film["point_id"] == film["point_id"].iloc[0]]
    screen, design = results.forces("screen"), results.forces("two_factor_design")
    fit = results.fit("screen")
    simulated = results.forces("extrapolation").set_index("point_id").loc[film["point_id"].iloc[0]]
    errors = results.validation_errors("two_factor_design", "error_map")
    force_n, error_n = float(simulated["force_n"]), float(simulated["force_error_n"])
    captions = {
        "Simulate": f"{force_n:.3f} N, numerical\nerror {rounded_up_text(error_n / force_n)} of it",
        "Fit": f"{len(screen)} simulations,\nerror {percent_text(fit.global_error)}",
        "Design": f"{len(design)} points\ninstead of {len(screen)}",
        "Validate": f"{errors['points']:.0f} simulations, largest\nerror "
        f"{percent_text(abs(errors['worst_relative_error']))}",
    }
    has_line = abs(errors["worst_relative_error"]) > errors["band"]
    band_line = f"; thick line: ±{100 * errors['band']:g} %" if has_line else ""
    figure = style.new_figure(height_in=5.0)
    figure.set_layout_engine("none")
    pressure = bool(film["gauge_pressure_kpa"].notna().all())
    point = f"h0 = {1e6 * simulated['h0_m']:g} µm, hv = {1e6 * simulated['hv_m']:g} µm"
    note = (
        f"1: {'pressure and gap' if pressure else 'gap'} at {point}; red: surface up, blue: down"
        f"{', black: mean pressure' * pressure}. 2: model (mesh) fitted to the screen (dots). "
        "3: screen (rings), optimal design (black). 4: error of the model fitted to the black "
        f"points, interpolated linearly{band_line}."
    )
    below = style.add_note(figure, note, results.validity_note)
    row_height = (1 - below) / 2
    bottoms = [below + row_height + LABELS_HEIGHT] * 2 + [below + LABELS_HEIGHT] * 2
    height = row_height - LABELS_HEIGHT - HEADING_HEIGHT
    look: dict[str, Any] = {"ha": "center", "va": "top"}
    places = zip(PANEL_LEFT_EDGES, bottoms, PANEL_WIDTHS, [height] * 4, strict=True)
    first, second, third, fourth = rectangles = [*places]
    for order, (place, step) in enumerate(zip(rectangles, captions, strict=True), start=1):
        middle, top = (0.27, 0.77)[order % 2 == 0], place[1] + height + HEADING_HEIGHT - 0.01
        figure.text(middle, top, f"{order}  {step}", fontsize=8, weight="bold", **look)
        figure.text(
            middle, top - 0.031, captions[step], fontsize=LABEL_FONT_SIZE, color="0.25", **look
        )
    points, few = (parts.gap_amplitude_table(table, layer="") for table in (screen, design))
    _draw_film(figure, film, first)
    _draw_model(figure, parts.model_mesh_table(fit, screen), points, second)
    axes = figure.add_axes(third)
    parts.draw_dots(
        axes, points, fill="white", **DOT_STYLE | {"markeredgecolor": "0.55", "markersize": 2.6}
    )
    parts.draw_dots(axes, few, fill="black", **DOT_STYLE, markersize=6)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 5, 10]))
    _label_axes(axes, *GAP_AXIS_LABELS)
    axes = figure.add_axes(fourth)
    filled, _ = parts.draw_error_contours(axes, results, bins=12, colors="0.3", linewidths=0.3)
    parts.draw_dots(axes, few, fill="black", **DOT_STYLE, markersize=4.5)
    _label_axes(axes, *GAP_AXIS_LABELS)
    box = axes.get_position()
    bar = figure.colorbar(filled, cax=figure.add_axes((box.x1 + 0.015, box.y0, 0.018, box.height)))
    bar.ax.tick_params(labelsize=TICK_FONT_SIZE, direction="out", pad=1, length=2)
    bar.set_label("error (%)", fontsize=LABEL_FONT_SIZE, labelpad=3)
    return figure


def _draw_lines_over_x(axes: Axes, film: pd.DataFrame, column: str) -> None:
    """One line for each time of the period, red while the surface is up."""
    highest = film["surface_um"].abs().max()
    for _, row in film.groupby("phase_deg"):
        height = max(row["surface_um"], key=abs)
        colour = mpl.colormaps["coolwarm"](0.5 + 0.5 * height / highest)
        axes.plot(row["x_mm"], row[column], color=colour, linewidth=0.5)
    axes.set_xlim(film["x_mm"].min(), film["x_mm"].max())
    axes.yaxis.set_major_locator(MaxNLocator(nbins=4, steps=[1, 2, 5, 10]))


def _label_axes(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x, fontsize=LABEL_FONT_SIZE)
    axes.set_ylabel(y, fontsize=LABEL_FONT_SIZE, labelpad=1)
    axes.tick_params(labelsize=TICK_FONT_SIZE)


def _draw_film(figure: Figure, film: pd.DataFrame, rectangle: PanelRectangle) -> None:
    """Above, the pressure at times of the period and its mean, if it is known; below, the gap."""
    left, bottom, width, height = rectangle
    if film["gauge_pressure_kpa"].notna().all():
        height = (height - 0.04) / 2
        above = figure.add_axes((left, bottom + height + 0.04, width, height))
        _draw_lines_over_x(above, film, "gauge_pressure_kpa")
        mean = film.groupby("x_mm", as_index=False)["gauge_pressure_kpa"].mean()
        above.plot(mean["x_mm"], mean["gauge_pressure_kpa"], color="black", linewidth=1.6)
        above.axhline(0, color="0.5", linewidth=0.4)
        above.tick_params(labelbottom=False)
        _label_axes(above, "", "p − p₀ (kPa)")
    below = figure.add_axes((left, bottom, width, height))
    _draw_lines_over_x(below, film, "surface_um")
    pad = film.groupby("x_mm")["pad_um"].mean()
    lowest = film.groupby("x_mm")["surface_um"].min()
    top = 1.35 * pad.max()
    below.fill_between(pad.index, lowest, pad, color="#e3eff7", linewidth=0)
    below.fill_between(pad.index, pad, top, color="#e8c4ac", linewidth=0)
    below.plot(pad.index, pad, color="#9c5b36")
    look: dict[str, Any] = {"ha": "center", "va": "center", "size": TICK_FONT_SIZE}
    below.text(0, (pad.max() + top) / 2, "pad", **look)
    below.text(0, pad.min() * 0.73, "gas film", **look)
    below.set_ylim(-1.3 * film["surface_um"].abs().max(), top)
    _label_axes(below, "position under the pad (mm)", "height (µm)")


def _draw_model(
    figure: Figure, model: pd.DataFrame, points: pd.DataFrame, rectangle: PanelRectangle
) -> None:
    """The model's mesh and the simulations, without room for the name of the force's axis."""
    labels = (r"$h_0$ (µm)", r"$h_v$ (µm)", "")
    axes = parts.add_3d_axes(figure, labels=labels, pads=(-9, -4), ticks=3)
    left, bottom, width, height = rectangle
    axes.set_position((left - 0.04, bottom - 0.07, width + 0.02, height + 0.09))
    axes.set_box_aspect((1.15, 1.15, 0.9), zoom=1.12)
    axes.tick_params(labelsize=TICK_FONT_SIZE)
    for axis in (axes.xaxis, axes.yaxis):
        axis.label.set_fontsize(LABEL_FONT_SIZE)
    figure.text(left - 0.06, bottom + 0.86 * height, "force (N)", fontsize=LABEL_FONT_SIZE)
    parts.draw_force_mesh(axes, model)
    parts.draw_force_points(axes, points, color=style.VERMILLION, s=5)
