"""Figure 16: the optimal points in four dimensions, in two projections."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reporting.figures import plane, style

COLUMNS = (
    "form",
    "point",
    "h0_um",
    "hv_um",
    "phi_r_mm",
    "phi_deg",
    *plane.LIMIT_COLUMNS,
    "phi_r_max_mm",
    "phi_max_deg",
    "note",
)
_LOOKS: tuple[dict[str, Any], ...] = (
    {"marker": "o", "color": style.BLUE, "markersize": 8, "markerfacecolor": "none"},
    {"marker": "D", "color": style.VERMILLION, "markersize": 4},
)


def draw(data: pd.DataFrame) -> Figure:
    """Panel a: amplitude over gap; panel b: radius over angle. Numbers tell the points apart."""
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=3.0)
    left, right = figure.subplots(1, 2)
    for order, (form, points) in enumerate(data.groupby("form", sort=False)):
        look = _LOOKS[order % len(_LOOKS)]
        for axes, x, y in ((left, "h0_um", "hv_um"), (right, "phi_deg", "phi_r_mm")):
            axes.plot(
                points[x],
                points[y],
                linestyle="none",
                clip_on=False,
                zorder=3,
                label=form if axes is left else None,
                **look,
            )
            _number(axes, points, x=x, y=y, above=order == 0, colour=look["color"])
    plane.set_up(left, data)
    left.set_title("(a)")
    radius = float(data["phi_r_max_mm"].iloc[0])
    plane.set_up_positions(right, data["phi_max_deg"], margin=0.1)
    right.set_ylim(-0.13 * radius, 1.15 * radius)
    right.set_title("(b)")
    figure.legend(loc="outside upper center", ncols=2, handletextpad=0.3)
    style.add_note(figure, data)
    return figure


def _number(axes: Axes, points: pd.DataFrame, *, x: str, y: str, above: bool, colour: str) -> None:
    """Write the points' numbers, together where points coincide in this projection."""
    places = points.assign(x=points[x].round(2), y=points[y].round(2)).groupby(["x", "y"])
    for (at_x, at_y), here in places:
        axes.annotate(
            ", ".join(f"{number}" for number in here["point"]),
            (at_x, at_y),
            xytext=(0, 6 if above else -6),
            textcoords="offset points",
            ha="center",
            va="bottom" if above else "top",
            fontsize=7,
            color=colour,
        )
