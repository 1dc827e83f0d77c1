"""What the film equation leaves out: each equation's error beside a resolved film, over Re.

Differences of the mean force on a long strip from that of a film with velocity resolved across the
gap: the Reynolds equation, the first order in Re and one mode across the gap; and, from that of a
film with temperature resolved too, heat left out and one mode of both.
"""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reporting.figures.parts import style

INPUTS = {
    "table": "numerics/resolved_strip.csv",
}
HEAT_LEFT_OUT = "resolved"
WITH_HEAT = (HEAT_LEFT_OUT, "one_mode_of_heat")  # against the film with heat
LINES = {
    "reynolds": (style.VERMILLION, "o-", "Reynolds equation"),
    "first_order": (style.ORANGE, "s-", "first order in Re"),
    "one_mode": (style.BLUE, "^-", "one mode"),
    HEAT_LEFT_OUT: (style.PURPLE, "d:", "heat left out"),
    "one_mode_of_heat": (style.GREEN, "v:", "one mode, and of heat"),
}
NOT_DRAWN = {"one_mode_heat", "resolved_heat"}
BOUNDS = (1e-3, 1e-2)
FLOOR = 1e-7


def draw(data: pd.DataFrame) -> Figure:
    """A panel for each amplitude, log-log; grey: what the resolved force itself is uncertain by."""
    style.check_known({*LINES, *NOT_DRAWN}, data["equation"], what="equation")
    panels = list(data.groupby("epsilon"))
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=0.9 + 2.0 * rows)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes, (epsilon, film) in zip(grid.flat, panels, strict=False):
        _panel(axes, film)
        axes.set_title(f"ε = {epsilon:g}")
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    for axes in grid[-1]:
        axes.set_xlabel("Re = ρ₀ωh₀²/μ")
    for axes in grid[:, 0]:
        axes.set_ylabel("relative difference")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=6)
    style.add_note(figure, data)
    return figure


def _panel(axes: Axes, film: pd.DataFrame) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(FLOOR, 2)
    axes.grid(True)
    yardstick = film[film["equation"] == "resolved"]
    axes.fill_between(
        yardstick["reynolds"],
        FLOOR,
        np.maximum(yardstick["estimated_error"], FLOOR),
        color="0.85",
        linewidth=0,
        label="uncertainty",
    )
    for bound in BOUNDS:
        axes.axhline(bound, color="0.4", linewidth=0.6, linestyle="--")
    for equation, (colour, line, label) in LINES.items():
        rows = film[film["equation"] == equation]
        difference = rows["from_resolved_heat" if equation in WITH_HEAT else "from_resolved"]
        axes.plot(rows["reynolds"], difference.abs(), line, color=colour, markersize=3, label=label)
