"""Where to simulate: the certificate of a D-optimal design.

Sensitivity of the locally D-optimal design of the fitted model. It is nowhere above one, and one at
the design's points (circles, their area the weight): by the equivalence theorem no design on this
space is better. The table beside it in results, `designs/optimal_*_plans.csv`, has the D-efficiency
of the study's own plans, the screen's among them.
"""

from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import plane, style

INPUTS = {
    "table": "designs/optimal_{space}_sensitivity.csv",
}
LEVELS = (0.2, 0.4, 0.6, 0.8, 0.9, 0.99)
LARGEST_DOT = 140
"""Area in points² of a design point with all the weight."""


def draw(data: pd.DataFrame) -> Figure:
    """d(x)/p over gap and amplitude, and over the finger's position where it moves."""
    moved = bool((data["layer"] == "position").any())
    width = style.DOUBLE_COLUMN_IN if moved else style.SINGLE_COLUMN_IN
    figure = style.new_figure(width_in=width, height_in=3.2)
    panels = figure.subplots(1, 2 if moved else 1, squeeze=False)[0]
    colours = _draw_panel(panels[0], data, "gap", ("h0_um", "hv_um"))
    panels[0].set_xlabel(plane.H0_LABEL)
    panels[0].set_ylabel(plane.HV_LABEL)
    if moved:
        _draw_panel(panels[1], data, "position", ("x_mm", "y_mm"))
        panels[1].set_xlabel("finger x (mm)")
        panels[1].set_ylabel("finger y (mm)")
    bar = figure.colorbar(colours, ax=list(panels), pad=0.02)
    bar.set_label("sensitivity d/p (–)")
    style.add_note(figure, data)
    return figure


def _draw_panel(axes: Any, data: pd.DataFrame, layer: str, names: tuple[str, str]) -> Any:
    rows, points = style.rows(data, layer), style.rows(data, "design")
    x, y, level = (rows[name].to_numpy(dtype=float) for name in (*names, "sensitivity"))
    shading = {"cmap": style.SEQUENTIAL, "vmin": 0.0, "vmax": 1.0}
    colours = axes.tripcolor(x, y, level, shading="gouraud", rasterized=True, **shading)
    reached = [each for each in LEVELS if level.min() < each < level.max()]
    if reached:
        axes.tricontour(x, y, level, levels=reached, colors="white", linewidths=0.5)
    axes.scatter(
        points[names[0]],
        points[names[1]],
        s=LARGEST_DOT * points["weight"].to_numpy(dtype=float),
        facecolor="none",
        edgecolor=style.VERMILLION,
        linewidths=1.4,
        clip_on=False,
        zorder=3,
    )
    return colours
