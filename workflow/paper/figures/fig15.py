"""Figure 15: the finger's positions of the four-factor plan."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures import plane, style

COLUMNS = ("phi_deg", "phi_r_mm", "phi_r_limit_mm", "note")


def draw(data: pd.DataFrame) -> Figure:
    """One dot per position; the dashed line is the largest radius on the actuator."""
    figure = style.new_figure()
    axes = figure.subplots()
    axes.axhline(
        data["phi_r_limit_mm"].iloc[0],
        color=style.VERMILLION,
        linestyle=(0, (4, 2)),
        label="finger stays on the actuator at every angle",
    )
    axes.plot(
        data["phi_deg"],
        data["phi_r_mm"],
        "o",
        color=style.BLUE,
        markersize=5,
        markeredgecolor="black",
        markeredgewidth=0.5,
        clip_on=False,
    )
    for angle in data["phi_deg"][data["phi_r_mm"] == 0]:
        axes.annotate(
            "centre: the same at every angle",
            (angle, 0),
            xytext=(8, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
        )
    top = 1.15 * max(data["phi_r_mm"].max(), data["phi_r_limit_mm"].max())
    axes.set_ylim(-0.06 * top, top)
    plane.set_up_positions(axes, data["phi_deg"], margin=1 / 15)
    figure.legend(loc="outside upper center", handlelength=1.8)
    style.add_note(figure, data)
    return figure
