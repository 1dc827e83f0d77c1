"""One optimal pattern of three points in the plane of gap and amplitude (Figures 10 and 11)."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures import plane, style

COLUMNS = ("layer", "epsilon", "h0_um", "hv_um", *plane.LIMIT_COLUMNS, "note")


def draw(data: pd.DataFrame) -> Figure:
    """Layers design (three dots) and ridge (the line of equal hv/h0 through each of them).

    Without a row of the layer design the plane stays empty and says so.
    """
    figure = style.new_figure()
    axes = figure.subplots()
    for _, line in style.rows(data, "ridge").groupby("epsilon"):
        axes.plot(line["h0_um"], line["hv_um"], color="0.55", linestyle=(0, (4, 2)), linewidth=0.9)
    design = style.rows(data, "design")
    axes.plot(
        design["h0_um"], design["hv_um"], "o", color="black", markersize=6, clip_on=False, zorder=3
    )
    plane.set_up(axes, data, headroom=0.3)
    labels = [
        f"({h0:.3g}, {hv:.3g}) µm\n$h_v/h_0$ = {epsilon:.3f}"
        for h0, hv, epsilon in zip(design["h0_um"], design["hv_um"], design["epsilon"], strict=True)
    ]
    plane.label_points(axes, design, labels=labels)
    if design.empty:
        axes.text(
            0.5,
            0.5,
            "no such pattern:\nall searches ended in the\npatterns shown before",
            transform=axes.transAxes,
            ha="center",
            va="center",
        )
    style.add_note(figure, data)
    return figure
