"""Figure 12: the optimal design's points among those of the screen."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures import plane, style

COLUMNS = ("layer", "h0_um", "hv_um", "label", *plane.LIMIT_COLUMNS, "note")


def draw(data: pd.DataFrame) -> Figure:
    """Layers screen (white dots) and design (black dots, each with a label)."""
    figure = style.new_figure()
    axes = figure.subplots()
    look: dict[str, Any] = {
        "marker": "o",
        "linestyle": "none",
        "markeredgecolor": "black",
        "clip_on": False,
    }
    screen, design = style.rows(data, "screen"), style.rows(data, "design")
    axes.plot(
        screen["h0_um"],
        screen["hv_um"],
        color="white",
        markersize=4,
        markeredgewidth=0.6,
        label=f"screen, {len(screen)} points",
        **look,
    )
    axes.plot(
        design["h0_um"],
        design["hv_um"],
        color="black",
        markersize=6,
        label=f"optimal design, {len(design)} points",
        **look,
    )
    plane.set_up(axes, data)
    plane.label_points(axes, design, labels=design["label"])
    figure.legend(loc="outside upper center", ncols=2, handletextpad=0.2)
    style.add_note(figure, data)
    return figure
