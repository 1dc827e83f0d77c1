"""Figure 7: the points of the screen in the plane of gap and amplitude."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures import plane, style

COLUMNS = ("h0_um", "hv_um", *plane.LIMIT_COLUMNS, "note")


def draw(data: pd.DataFrame) -> Figure:
    """One dot per simulation."""
    figure = style.new_figure()
    axes = figure.subplots()
    axes.plot(
        data["h0_um"],
        data["hv_um"],
        "o",
        markersize=4,
        color=style.BLUE,
        markeredgecolor="black",
        markeredgewidth=0.5,
        clip_on=False,
    )
    plane.set_up(axes, data)
    style.add_note(figure, data)
    return figure
