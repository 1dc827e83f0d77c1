"""Fitted models, D-optimal designs, models compared and refined."""

from math import ceil
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, SymLogNorm
from matplotlib.figure import Figure

from squeezefilm.models.data import factors_of_table
from squeezefilm.models.fit_file import FittedModel
from squeezefilm.tables import ERROR_MAP_COLUMNS, REFINEMENT_ROUND_COLUMNS
from squeezefilm_workflow.reporting.figures import parts, style
from squeezefilm_workflow.reporting.notes import (
    percent_text,
    simulation_error_note,
)
from squeezefilm_workflow.reporting.results import Results

STYLE_OF_LAYER: dict[str, dict[str, Any]] = {
    "simulation": {"color": style.VERMILLION, "label": "simulation"},
    "control": {"color": "white", "label": "control point"},
    "design": {"color": "black", "label": "design point", "s": 26},
}
"""Looks of simulations beside a model's mesh."""
PANELS_PER_ROW = 4
DECADES_SHOWN = 5
CONTOUR_LEVELS = (0.2, 0.4, 0.6, 0.8, 0.9, 0.99)
MAX_DOT_SIZE = 140
"""Area in points² of a design point with all the weight."""
AXES_OF_PLANE = {
    "gap": (("h0_um", "hv_um"), parts.GAP_AMPLITUDE_LABELS),
    "position": (("x_mm", "y_mm"), {"xlabel": "pad x (mm)", "ylabel": "pad y (mm)"}),
}
"""Layers of a design's sensitivity; their columns and labels."""
LINEAR_THRESHOLD_FRACTION = 0.02
"""Share of the largest error, at least, up to which a map's colours are linear."""


def fitted_model(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The model fitted to the screen (mesh) and the simulations (dots)."""
    fit = results.fit("screen")
    note = f"Fit on {fit.points} points: global error {percent_text(fit.global_error)}."
    return model_and_points_figure(results, fit, note, simulation="screen")


def design(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The design (black, with the letters of its patterns, + if added) on the screen (white)."""
    screen = results.scenes("screen")
    optimal = results.design("two_factor")
    labels = optimal["origin"].str.replace(" and ", ", ").replace("augmentation", "+")
    points = parts.gap_amplitude_table(optimal, layer="design").assign(label=labels)
    data = pd.concat([parts.gap_amplitude_table(screen, layer="screen"), points], ignore_index=True)
    figure, axes = style.subplots()
    label = f"screen, {len(screen)} points"
    white = style.layer_rows(data, "screen")
    parts.draw_dots(axes, white, fill="white", markersize=4, markeredgewidth=0.6, label=label)
    label = f"optimal design, {len(optimal)} points"
    parts.draw_dots(axes, points, fill="black", markersize=6, label=label)
    parts.set_up_gap_amplitude_axes(axes, screen)
    parts.label_points(axes, points, labels=points["label"])
    figure.legend(loc="outside upper center", ncols=2, handletextpad=0.2)
    note = "Letters: a point's locally optimal patterns; +: added by augmentation."
    style.add_note(figure, note, results.validity_note)
    return figure, data


def model_and_points_figure(
    results: Results, fit: FittedModel, note: str, **plans: str
) -> tuple[Figure, pd.DataFrame]:
    """A fit as a mesh, and the simulations of plans as dots, each a layer with its look."""
    tables = [parts.model_mesh_table(fit, results.scenes("screen"))]
    forces = [results.forces(plan) for plan in plans.values()]
    figure = style.new_figure(height_in=3.1)
    notes = (note, simulation_error_note(*forces), results.validity_note)
    axes = parts.add_3d_axes(figure, bottom=style.add_note(figure, *notes))
    parts.draw_force_mesh(axes, tables[0])
    for layer, simulated in zip(plans, forces, strict=True):
        tables.append(parts.gap_amplitude_table(simulated, layer=layer))
        parts.draw_force_points(axes, tables[-1], **STYLE_OF_LAYER[layer])
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.97), handletextpad=0.2)
    return figure, pd.concat(tables, ignore_index=True)


def _text_only_figure(text: str) -> Figure:
    """Return a figure that shows a text alone."""
    figure = style.new_figure(wide=True, height_in=1.0)
    figure.text(0.5, 0.6, text, ha="center")
    return figure


def model_errors_figure(results: Results, space: str) -> Figure:
    """A panel for each model: errors on the validation sample, larger ones over smaller ones."""
    table = results.table(f"models/{space}.csv", "model", "parameters", "validation_error")
    judged = table.dropna(subset="validation_error").sort_values("validation_error", kind="stable")
    if judged.empty:
        return _text_only_figure("no model has an error on these points")
    data = results.table(f"models/{space}_errors.csv", "model", "h0_m", "hv_m", "relative_error")
    data = parts.with_micrometre_columns(data).assign(size=100 * data["relative_error"].abs())
    across = min(PANELS_PER_ROW, len(judged))
    down = ceil(len(judged) / across)
    figure = style.new_figure(wide=True, height_in=0.5 + 1.85 * down)
    panels = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False).ravel()
    top = max(float(data["size"].max()), 1e-10)
    norm = LogNorm(top * 10.0**-DECADES_SHOWN, top, clip=True)
    for axes in panels[len(judged) :]:
        axes.set_visible(False)
    for number, (axes, model) in enumerate(zip(panels, judged.to_dict("records"), strict=False)):
        rows = data[data["model"] == model["model"]].sort_values("size", kind="stable")
        dots = parts.draw_coloured_dots(
            axes, rows, "size", s=5, norm=norm, cmap=style.SEQUENTIAL_COLOURMAP
        )
        share = percent_text(model["validation_error"])
        axes.set_title(f"{model['model']} ({model['parameters']:.0f})\n{share}", fontsize=7)
        lowest_of_column = number >= len(judged) - across
        axes.set(**parts.GAP_AMPLITUDE_LABELS)
        axes.yaxis.label.set_visible(number % across == 0)
        axes.xaxis.label.set_visible(lowest_of_column)
        axes.tick_params(labelsize=6, labelbottom=lowest_of_column)
    label = "|relative error| (%)"
    figure.colorbar(dots, ax=list(panels), pad=0.02, extend="min", label=label)
    note = "One dot a simulation; above each panel: number of parameters, global error."
    style.add_note(figure, note, results.validity_note)
    return figure


def sensitivity_figure(results: Results, space: str) -> Figure:
    """d(x)/p over gap and amplitude, and over the pad's position where it moves."""
    data = results.table(f"designs/optimal_{space}_sensitivity.csv", "layer", "sensitivity")
    moved = bool((data["layer"] == "position").any())
    figure, (panels,) = style.subplots(1, 1 + moved, wide=moved, height_in=3.2, squeeze=False)
    for axes, (layer, (names, labels)) in zip(panels, AXES_OF_PLANE.items(), strict=False):
        colours = _draw_design_sensitivity(axes, data, layer, names)
        axes.set(**labels)
    figure.colorbar(colours, ax=list(panels), pad=0.02, label="sensitivity d/p (–)")
    notes = (
        "Circles: design points, their area the weight. Colours: interpolated linearly.",
        "The design is optimal where d/p nowhere exceeds 1.",
    )
    style.add_note(figure, *notes, results.validity_note)
    return figure


def _draw_design_sensitivity(
    axes: Axes, data: pd.DataFrame, layer: str, names: tuple[str, str]
) -> Any:
    rows, points = style.layer_rows(data, layer), style.layer_rows(data, "design")
    x, y, level = (rows[name].to_numpy(dtype=float) for name in (*names, "sensitivity"))
    shading: dict[str, Any] = {"cmap": style.SEQUENTIAL_COLOURMAP, "vmin": 0.0, "vmax": 1.0}
    colours = axes.tripcolor(x, y, level, shading="gouraud", rasterized=True, **shading)
    reached = [each for each in CONTOUR_LEVELS if level.min() < each < level.max()]
    if reached:
        lines = axes.tricontour(x, y, level, levels=reached, colors="white", linewidths=0.7)
        parts.label_contours(axes, lines, "{:g}".format)
    *place, weight = (points[name].to_numpy(dtype=float) for name in (*names, "weight"))
    look: dict[str, Any] = {"edgecolor": style.VERMILLION, "linewidths": 1.4, "clip_on": False}
    axes.scatter(place[0], place[1], MAX_DOT_SIZE * weight, facecolor="none", zorder=3, **look)
    return colours


def refinement_figure(results: Results, space: str) -> Figure:
    """A row for each refined model: errors against simulations, maps of gap and of position."""
    table = results.table(f"refine/{space}.csv", "model", "verdict", "simulations")
    table = table[table["verdict"] != "not supported"]
    if table.empty:
        return _text_only_figure("no model of this space was refined")
    simulated = {
        model: _factors_in_figure_units(
            results.table(f"refine/{space}/{model}/forces.csv", "h0_m", "hv_m")
        )
        for model in table["model"]
    }
    moved = any(bool(places["x_mm"].abs().max() > 0) for places in simulated.values())
    figure = style.new_figure(wide=True, height_in=0.5 + 2.1 * len(table))
    panels = figure.subplots(len(table), 2 + moved, squeeze=False)
    for row, (_, model) in zip(panels, table.iterrows(), strict=True):
        folder = f"refine/{space}/{model['model']}"
        verdict = results.read_json_file(f"{folder}/verdict.json")
        rounds = results.table(f"{folder}/rounds.csv", *REFINEMENT_ROUND_COLUMNS)
        _draw_refinement_rounds(row[0], rounds, required=verdict["required"], truth=model)
        row[0].set_title(f"{model['model']}: {model['verdict']}")
        sample = style.layer_rows(
            results.table(f"{folder}/where.csv", *ERROR_MAP_COLUMNS), "sample"
        )
        error_percent = 100 * sample["error_n"].astype(float) / verdict["mean_force_n"]
        places = _factors_in_figure_units(sample).assign(error_percent=error_percent)
        points = simulated[model["model"]]
        for axes, (names, labels) in zip(row[1:], AXES_OF_PLANE.values(), strict=False):
            dots = _draw_error_dots(axes, places, points, *names)
            axes.set(**labels)
        bar = figure.colorbar(dots, ax=row[-1], pad=0.02, label="error (%)")
        bar.ax.tick_params(labelsize=6)
    shown = dict(zip(*reversed(panels[0][0].get_legend_handles_labels()), strict=True))
    figure.legend(shown.values(), shown, loc="outside upper center", ncols=4, handletextpad=0.4)
    notes = "Bars: 95 % limits of the global error.", "Circles in maps: fitted simulations."
    style.add_note(figure, *notes, results.validity_note)
    return figure


def _factors_in_figure_units(table: pd.DataFrame) -> pd.DataFrame:
    """The table with the four factors in the figures' units."""
    at = factors_of_table(table)
    return parts.with_micrometre_columns(table).assign(x_mm=1e3 * at.x_m, y_mm=1e3 * at.y_m)


def _draw_refinement_rounds(
    axes: Any, rounds: pd.DataFrame, *, required: Any, truth: pd.Series
) -> None:
    """Estimates with their limits, the required errors dashed, the truth as stars."""
    rounds = rounds.assign(
        **{name: 100 * rounds[name] for name in REFINEMENT_ROUND_COLUMNS if "_" in name}
    )
    for name, colour, label in (
        ("worst_error", style.VERMILLION, "worst error, estimated"),
        ("global_error", style.BLUE, "global error, estimated"),
    ):
        known = rounds[np.isfinite(rounds[name])]
        axes.plot(known["simulations"], known[name], "o-", color=colour, markersize=3, label=label)
        axes.axhline(100 * required[name], color=colour, linestyle="--", linewidth=0.6)
        star = 100 * truth[f"held_out_{name}"]
        axes.plot(truth["simulations"], star, "*", color=colour, markersize=8, mec="black")
    axes.plot([], [], "--", color="black", linewidth=0.6, label="target")
    axes.plot([], [], "*", color="white", markersize=8, mec="black", label="at unused simulations")
    limits = rounds[["global_lower", "global_upper"]].sub(rounds["global_error"], axis=0).abs()
    bars = {"fmt": "none", "color": style.BLUE, "linewidth": 0.8, "capsize": 2}
    axes.errorbar(rounds["simulations"], rounds["global_error"], yerr=limits.T, **bars)
    axes.set_yscale("log")
    axes.set_xlim(rounds["simulations"].min() - 1, rounds["simulations"].max() + 1)
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set(xlabel="simulations (–)", ylabel="error (%)")
    axes.grid(axis="y")


def _draw_error_dots(
    axes: Axes, sample: pd.DataFrame, simulated: pd.DataFrame, x: str, y: str
) -> Any:
    """The error at a fair sample of the space, the largest on top; simulated points circled."""
    sample = sample.sort_values("error_percent", key=np.abs)
    top = max(float(sample["error_percent"].abs().max()), 1e-12)
    # Linear up to a power of ten, so that the ticks keep apart.
    norm = SymLogNorm(
        linthresh=10 ** np.ceil(np.log10(LINEAR_THRESHOLD_FRACTION * top)), vmin=-top, vmax=top
    )
    look: dict[str, Any] = {"norm": norm, "cmap": style.DIVERGING_COLOURMAP, "s": 6}
    dots = parts.draw_coloured_dots(axes, sample, "error_percent", x=x, y=y, **look)
    axes.plot(simulated[x], simulated[y], "o", mfc="none", mec="black", mew=0.6, markersize=4)
    axes.tick_params(labelsize=6)
    return dots
