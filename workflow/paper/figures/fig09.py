"""Figure 9: the triplets that the searches for a D-optimal design ended in."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reporting.figures import plane, style

COLUMNS = ("scaling", "search", "pattern", "h0_um", "hv_um", *plane.LIMIT_COLUMNS, "note")

_LOOKS = (
    (style.BLUE, "o"),
    (style.VERMILLION, "^"),
    (style.GREEN, "s"),
    (style.PURPLE, "D"),
    (style.ORANGE, "v"),
)
_TITLES = {
    "unit": "factors scaled to [0, 1]",
    "micrometre": "factors in µm",
    "metre": "factors in m",
}


def draw(data: pd.DataFrame) -> Figure:
    """A panel for each scaling of the factors; a triangle of three dots for each search."""
    scalings = list(dict.fromkeys(data["scaling"]))
    wide = len(scalings) > 1
    figure = style.new_figure(
        width_in=style.DOUBLE_COLUMN_IN if wide else style.SINGLE_COLUMN_IN, height_in=2.75
    )
    panels = figure.subplots(1, len(scalings), squeeze=False, sharey=True)[0]
    for letter, axes, scaling in zip("abcdefgh", panels, scalings, strict=False):
        _draw_searches(axes, data[data["scaling"] == scaling])
        plane.set_up(axes, data)
        axes.set_title(f"({letter}) " * wide + _TITLES.get(scaling, scaling))
        axes.label_outer()
    style.add_note(figure, data)
    return figure


def _draw_searches(axes: Axes, data: pd.DataFrame) -> None:
    searches = data["search"].nunique()
    for order, (pattern, found) in enumerate(data.groupby("pattern", sort=True)):
        colour, marker = _LOOKS[order % len(_LOOKS)]
        count = found["search"].nunique()
        label: str | None = f"{pattern}: {count} of {searches} searches"
        for _, triplet in found.groupby("search"):
            closed = pd.concat([triplet, triplet.iloc[:1]])
            axes.plot(
                closed["h0_um"],
                closed["hv_um"],
                color=colour,
                linewidth=0.5,
                linestyle=(0, (4, 2)) if order else "-",
                marker=marker,
                markersize=7 - 2 * min(order, 2),
                markerfacecolor="none" if order == 0 else colour,
                markeredgewidth=0.8,
                label=label,
                zorder=2 + order,
            )
            label = None
    axes.legend(loc="lower left", handlelength=1.6, labelspacing=0.3)
