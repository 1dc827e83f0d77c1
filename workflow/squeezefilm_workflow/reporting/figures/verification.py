"""The solver examined: stiff and extreme films, and its error against run time."""

from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from squeezefilm_workflow.reporting.figures import parts, style
from squeezefilm_workflow.reporting.results import Results

STYLE_OF_METHOD = {
    "solver": ("black", "o", "-"),
    "solver, in a batch": ("black", "o", ":"),
    "same algorithm, NumPy, no symmetry": (style.BLUE, "D", "-"),
    "Chebyshev, Radau, Anderson": (style.GREEN, "v", "-"),
    "finite elements, Anderson": (style.PURPLE, "<", "-"),
    "finite elements from rest": (style.VERMILLION, "p", "-"),
    "collocation, dense matrices": (style.GREY, "s", "-"),
}
"""Colour, marker and line of each method."""
MARKER_OF_VERDICT = {"solved": "o", "unchecked": "D", "not supported": "s", "failed": "X"}
EPSILON_TICKS = (0.001, 0.1, 0.5, 0.9, 0.99)
MAX_DRAWN_EPSILON = 0.998
DOT_OFFSET_DECADES = 0.25
"""Of films in one place, in decades of σ."""
PAD_OFFSET_DECADES = 0.09
"""Of discs to the left and of squares to the right, in decades of Re."""


def stability(results: Results) -> Figure:
    """Left the films without inertia over (ε, σ), beside it those with inertia over (Re, σ)."""
    data = results.table("numerics/stability.csv", "verdict", "worst_ratio", "terms")
    data = data.sort_values("epsilon", kind="stable")
    figure = style.new_figure(wide=True, height_in=4.4)
    left, middle, right = figure.subplots(1, 3, width_ratios=(3, 2, 2), sharey=True)
    moving = data["modified_reynolds"] > 0
    thermal = data["terms"].str.contains("thermal effects")
    pad_offset = (
        np.where(data["case"].str.startswith("disc"), -PAD_OFFSET_DECADES, PAD_OFFSET_DECADES)
        * thermal
    )
    shown = _draw_films(left, data[~moving].assign(x=data["epsilon"].clip(upper=MAX_DRAWN_EPSILON)))
    left.set(xscale="logit", xlabel="excursion ratio ε (–)")
    left.set_xticks(EPSILON_TICKS, [f"{tick:g}" for tick in EPSILON_TICKS])
    left.set(xlim=(4e-4, 0.9988), ylabel="squeeze number σ (–)", title="(a) without inertia")
    data = data.assign(x=data["modified_reynolds"] * 10**pad_offset)
    for panel, films, limits, title in (
        (middle, data[moving & ~thermal], (0.2, 120), "(b) inertia"),
        (right, data[thermal], (0.05, 40), "(c) thermal effects"),
    ):
        _draw_films(panel, films)
        panel.set(xscale="log", xlim=limits, xlabel="Re (–)", title=title)
    label = "largest deviation over the allowed one (–)"
    figure.colorbar(shown, ax=(left, middle, right), pad=0.01, aspect=40, label=label)
    for verdict, count in data["verdict"].value_counts().items():
        marker = MARKER_OF_VERDICT[str(verdict)]
        left.plot([], [], marker, color="0.4", linestyle="", label=f"{verdict} ({count})")
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    note = (
        "Films of one place are drawn one above the other, ε rising; (c) has inertia too, discs "
        "left of each Re, squares right; white: no check."
    )
    style.add_note(figure, note)
    return figure


def _draw_films(axes: Axes, films: pd.DataFrame) -> PathCollection:
    """Draw a dot per film, coloured by its worst deviation, coincident ones apart."""
    positions = films.groupby(["x", "sigma"])
    rank = positions.cumcount() - (positions["x"].transform("size") - 1) / 2
    films = films.assign(y=films["sigma"] * 10 ** (DOT_OFFSET_DECADES * rank))
    cmap = mpl.colormaps[style.SEQUENTIAL_COLOURMAP].with_extremes(bad="white")
    look: dict[str, Any] = {"cmap": cmap, "norm": LogNorm(1e-4, 1.0, clip=True), "s": 26}
    look |= {"edgecolors": "0.3", "linewidths": 0.6, "plotnonfinite": True, "x": "x", "y": "y"}
    for verdict, marker in MARKER_OF_VERDICT.items():
        films_of_verdict = films[films["verdict"] == verdict]
        dots = parts.draw_coloured_dots(
            axes, films_of_verdict, "worst_ratio", marker=marker, **look
        )
    axes.set_yscale("log")
    axes.grid(True)
    return dots


def work_precision(results: Results) -> Figure:
    """A panel for each film, a line for each method."""
    data = results.table("numerics/work_precision.csv", "case", "method", "relative_error")

    films = data["case"].unique()
    columns = min(2, len(films))
    rows = -(-len(films) // columns)
    figure = style.new_figure(wide=True, height_in=1.2 + 2.3 * rows)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    lowest = 0.2 * float(data["reference_uncertainty"].min())
    for panel, film in zip(panels, films, strict=False):
        here = data[data["case"] == film]
        floor = float(here["reference_uncertainty"].iloc[0])
        panel.axhline(float(here["model_error"].iloc[0]), color=style.ORANGE, linewidth=1.5)
        panel.axhspan(lowest, floor, color="0.85", linewidth=0, zorder=0)
        for method, (colour, marker, line) in STYLE_OF_METHOD.items():
            path = here[(here["method"] == method) & (here["status"] == "ok")]
            look: dict[str, Any] = {"color": colour, "marker": marker, "linestyle": line, "ms": 4}
            look["mfc"] = "white" if line == ":" else colour
            error = np.maximum(path["relative_error"], floor)
            panel.plot(path["cpu_s"], error, label=method, **look)
        panel.set(title=film, xscale="log", yscale="log", ylim=(lowest, 1))
        panel.set(xlabel="processor time per film (s)", ylabel="relative error of the force (–)")
        panel.grid(True)
        panel.label_outer()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    note = "Orange: error of the empirical model; grey: below the uncertainty of the reference."
    style.add_note(figure, note)
    return figure


def published(results: Results) -> Figure:
    """Left exact profiles beside finite elements, right depth averaging beside exact profiles."""
    data = results.table("numerics/published.csv", "source", "exact_deviation")

    figure, (left, right) = style.subplots(1, 2, wide=True, height_in=4.0, sharey=True)
    profiles = data.dropna(subset=["viscous_deviation"])
    holes = profiles.dropna(subset=["exact_deviation"]).groupby("quantity")
    for fill, (quantity, films) in zip(("white", None), holes, strict=True):
        for column, name, colour, marker in (
            ("viscous_deviation", "Reynolds equation", style.VERMILLION, "s"),
            ("exact_deviation", "exact profiles", style.BLUE, "o"),
        ):
            label = f"{name}, {str(quantity).partition(', ')[2]}"
            look: dict[str, Any] = {"color": colour, "mfc": fill, "ms": 4, "label": label}
            look["zorder"] = 3 if fill else 2  # open ones are not hidden by filled ones
            left.plot(films["modified_reynolds"], films[column], marker, **look)
    left.set(ylabel="relative deviation (–)", title="(a) pressure: from finite elements")
    averaged = profiles[profiles["case"].str.startswith("inertia")]
    colours = mpl.colormaps[style.SEQUENTIAL_COLOURMAP](
        np.linspace(0, 0.85, averaged["sigma"].nunique())
    )
    for colour, (sigma, films) in zip(colours, averaged.groupby("sigma"), strict=True):
        for case, line, label in (
            ("inertia", "o-", f"σ = {sigma:g}"),
            ("inertia and thermal effects", "D:", ""),
        ):
            look = {"color": colour, "ms": 3, "label": label}
            films_of_case = films[films["case"] == case]
            right.plot(
                films_of_case["modified_reynolds"], films_of_case["solver_deviation"], line, **look
            )
    right.plot([], [], "D:", color="0.3", ms=3, label="with thermal effects")
    right.set_title("(b) force: depth averaging from exact profiles")
    for panel in (left, right):
        panel.set(xscale="log", yscale="log", xlabel="modified Reynolds number Re (–)")
        panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16))  # hides no point
        panel.grid(True)
    note = "(a) given: where the pressure is prescribed; (b) first harmonic of the force."
    style.add_note(figure, note)
    return figure
