"""Overview: what the whole study does.

A film is simulated over a period; a model is fitted to the simulations of a screen; the points at
which simulations teach most are found; the model fitted to these alone is judged on many more
simulations.
"""

from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from reporting.figures.parts import plane, style, surface
from reporting.figures.parts.errors import error_table
from reporting.figures.parts.tables import Inputs, model_mesh, plane_table
from reporting.pages.notes import percent, rounded_up
from squeezefilm.config.loading import Config
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import read_json, read_ok_forces
from squeezefilm.models.fitted import number, read_fit

INPUTS = {
    "film": "simulations/extrapolation/film.csv",
    "film_forces": "simulations/extrapolation/forces.csv",
    "forces": "simulations/screen/forces.csv",
    "fit": "fits/screen.json",
    "design_forces": "simulations/two_factor_design/forces.csv",
    "errors": "validation/two_factor_design_on_error_map.csv",
    "validation": "validation/two_factor_design_on_error_map.json",
}
FILM_COLUMNS = ("phase_deg", "x_mm", "surface_um", "finger_um", "overpressure_kpa")
STEPS = ("Simulate", "Fit", "Design", "Validate")
# Left edge and width of each step's axes, as shares of the figure's width.
PLACES = ((0.055, 0.175), (0.255, 0.235), (0.545, 0.17), (0.775, 0.155))
TOP = 0.82
GAP_LABEL, AMPLITUDE_LABEL = r"gap $h_0$ (µm)", r"amplitude $h_v$ (µm)"
LABEL_SIZE, TICK_SIZE = 6.5, 6
DOTS: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.6, "zorder": 4}
SCREEN = {"markeredgecolor": "0.55", "markersize": 2.6}


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers film, model, simulation, design and map, and four captions in column text."""
    film = read_columns(inputs["film"], columns=("point_id", *FILM_COLUMNS))
    point = film["point_id"].iloc[0]
    forces, fit = read_ok_forces(inputs["forces"]), read_fit(inputs["fit"])
    simulated = read_ok_forces(inputs["film_forces"]).set_index("point_id").loc[point]
    design = read_ok_forces(inputs["design_forces"])
    summary = read_json(inputs["validation"])
    worst, points = (
        number(summary, key, inputs["validation"]) for key in ("worst_relative_error", "points")
    )
    force_n, error_n = float(simulated["force_n"]), float(simulated["force_error_n"])
    captions = (
        f"{force_n:.3f} N, numerical error "
        f"{rounded_up(error_n / force_n + fit.profile_uncertainty)} of it",
        f"{len(forces)} simulations, error {percent(fit.global_error)}",
        f"{len(design)} points instead of {len(forces)}",
        f"{points:.0f} simulations: at most {percent(abs(worst))} off",
    )
    data = pd.concat(
        [
            film.loc[film["point_id"] == point, list(FILM_COLUMNS)].assign(layer="film"),
            model_mesh(fit, forces),
            plane_table(forces, layer="simulation"),
            plane_table(design, layer="design"),
            error_table(inputs["errors"], inputs["validation"], layer="map"),
            pd.DataFrame({"layer": "caption", "text": captions}),
        ],
        ignore_index=True,
    )
    estimate = rounded_up(float((forces["force_error_n"] / forces["force_n"]).max()))
    scan = (
        f", of the scan up to {percent(fit.profile_uncertainty)}" if fit.profile_uncertainty else ""
    )
    seen = f"at {film['phase_deg'].nunique()} times of a period (red: surface up)"
    if film["overpressure_kpa"].notna().all():  # where there is a state to show (cross_section)
        seen = f"its pressure {seen} and their mean (thick)"
    note = (
        f"From left to right: a film at h0 = {1e6 * simulated['h0_m']:g} µm, "
        f"hv = {1e6 * simulated['hv_m']:g} µm, "
        f"{seen}; the model fitted to the screen; the "
        "D-optimal points beside the screen's; the error of the model fitted to them alone. "
        f"Estimated error of the simulations ≤ {estimate} of the force{scan}, beside what the "
        "equation leaves out."
    )
    return data.assign(note=note)


def draw(data: pd.DataFrame) -> Figure:
    """Layers film; model and simulation; design; map: a step each, with the captions above."""
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=2.8)
    figure.set_layout_engine("none")
    bottom = style.add_note(figure, data) + 0.135
    captions = list(style.rows(data, "caption")["text"])
    for order, ((left, width), step, caption) in enumerate(
        zip(PLACES, STEPS, captions, strict=True), start=1
    ):
        middle = left + width / 2
        figure.text(middle, 0.935, f"{order}  {step}", ha="center", fontsize=9, weight="bold")
        figure.text(middle, 0.87, caption, ha="center", fontsize=LABEL_SIZE, color="0.25")
    _film(figure, style.rows(data, "film"), bottom=bottom)
    left, width = PLACES[1]
    _model(figure, data, rectangle=(left, bottom - 0.12, width, TOP + 0.14 - bottom))
    height = TOP - bottom
    _design(figure.add_axes((PLACES[2][0], bottom, PLACES[2][1], height)), data)
    _errors(figure.add_axes((PLACES[3][0], bottom, PLACES[3][1], height)), data)
    return figure


def _film(figure: Figure, film: pd.DataFrame, *, bottom: float) -> None:
    """Above, the pressure at times of the period and its mean, if it is known; below, the gap."""
    left, width = PLACES[0]
    height = TOP - bottom
    if film["overpressure_kpa"].notna().all():
        height = (height - 0.04) / 2
        above = figure.add_axes((left, bottom + height + 0.04, width, height))
        _pressure(above, film)
    _gap(figure.add_axes((left, bottom, width, height)), film)


def _curves(axes: Axes, film: pd.DataFrame, column: str) -> None:
    """One line for each time of the period, red while the surface is up."""
    highest = film["surface_um"].abs().max()
    for _, row in film.groupby("phase_deg"):
        height = max(row["surface_um"], key=abs)
        colour = mpl.colormaps["coolwarm"](0.5 + 0.5 * height / highest)
        axes.plot(row["x_mm"], row[column], color=colour, linewidth=0.5)
    axes.set_xlim(film["x_mm"].min(), film["x_mm"].max())
    axes.yaxis.set_major_locator(MaxNLocator(nbins=4, steps=[1, 2, 5, 10]))
    axes.tick_params(labelsize=TICK_SIZE)


def _pressure(above: Axes, film: pd.DataFrame) -> None:
    _curves(above, film, "overpressure_kpa")
    mean = film.groupby("x_mm", as_index=False)["overpressure_kpa"].mean()
    above.plot(mean["x_mm"], mean["overpressure_kpa"], color="black", linewidth=1.6)
    above.axhline(0, color="0.5", linewidth=0.4)
    above.tick_params(labelbottom=False)
    above.set_ylabel("p − p₀ (kPa)", fontsize=LABEL_SIZE, labelpad=1)


def _gap(below: Axes, film: pd.DataFrame) -> None:
    _curves(below, film, "surface_um")
    mean = film.groupby("x_mm", as_index=False)["finger_um"].mean()
    top = 1.35 * mean["finger_um"].max()
    lowest = film.groupby("x_mm")["surface_um"].min().to_numpy()
    below.fill_between(mean["x_mm"], lowest, mean["finger_um"], color="#e3eff7", linewidth=0)
    below.fill_between(mean["x_mm"], mean["finger_um"], top, color="#e8c4ac", linewidth=0)
    below.plot(mean["x_mm"], mean["finger_um"], color="#9c5b36")
    below.text(
        0, (mean["finger_um"].max() + top) / 2, "finger", ha="center", va="center", size=TICK_SIZE
    )
    below.text(
        0, mean["finger_um"].min() * 0.73, "film of air", ha="center", va="center", size=TICK_SIZE
    )
    below.set_ylim(-1.3 * film["surface_um"].abs().max(), top)
    below.set_ylabel("height (µm)", fontsize=LABEL_SIZE, labelpad=1)
    below.set_xlabel("place under the finger (mm)", fontsize=LABEL_SIZE)


def _model(
    figure: Figure, data: pd.DataFrame, *, rectangle: tuple[float, float, float, float]
) -> None:
    axes = surface.add_force_axes(figure, bottom=0)
    axes.set_position(rectangle)
    axes.set_box_aspect((1.15, 1.15, 0.9), zoom=1.12)
    axes.tick_params(labelsize=TICK_SIZE, pad=-4)
    for axis, label in (
        (axes.xaxis, r"$h_0$ (µm)"),
        (axes.yaxis, r"$h_v$ (µm)"),
        (axes.zaxis, ""),
    ):
        axis.set_major_locator(MaxNLocator(nbins=3, steps=[1, 2, 5, 10]))
        axis.set_label_text(label, fontsize=LABEL_SIZE)
        axis.labelpad = -9
    left, low, _, height = rectangle
    figure.text(left - 0.005, low + 0.76 * height, "force (N)", fontsize=LABEL_SIZE)
    surface.force_mesh(axes, style.rows(data, "model"))
    surface.force_points(
        axes, style.rows(data, "simulation"), color=style.VERMILLION, label="simulation", s=5
    )


def _design(axes: Axes, data: pd.DataFrame) -> None:
    plane.dots(axes, style.rows(data, "simulation"), fill="white", **DOTS | SCREEN)
    plane.dots(axes, style.rows(data, "design"), fill="black", **DOTS, markersize=6)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 5, 10]))
    axes.set_xlabel(GAP_LABEL, fontsize=LABEL_SIZE)
    axes.set_ylabel(AMPLITUDE_LABEL, fontsize=LABEL_SIZE, labelpad=1)
    axes.tick_params(labelsize=TICK_SIZE)


def _errors(axes: Axes, data: pd.DataFrame) -> None:
    filled, _ = plane.error_contours(
        axes, style.rows(data, "map"), bins=12, ticks=(1, 2, 5), colors="0.3", linewidths=0.3
    )
    plane.dots(axes, style.rows(data, "design"), fill="black", **DOTS, markersize=4.5)
    axes.set_xlabel(GAP_LABEL, fontsize=LABEL_SIZE)
    axes.set_ylabel(AMPLITUDE_LABEL, fontsize=LABEL_SIZE, labelpad=1)
    axes.tick_params(labelsize=TICK_SIZE)
    figure = axes.figure
    assert isinstance(figure, Figure)
    box = axes.get_position()
    bar = figure.colorbar(filled, cax=figure.add_axes((box.x1 + 0.008, box.y0, 0.009, box.height)))
    bar.ax.tick_params(labelsize=TICK_SIZE, direction="out", pad=1, length=2)
    bar.set_label("error (%)", fontsize=LABEL_SIZE, labelpad=0)
