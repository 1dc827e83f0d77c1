"""Stiff and extreme films: verdicts, and the worst deviation that a check found, over its bound.

Over amplitude and squeeze number, and of films with inertia over its number Re. The checks know
nothing of the solver; films of one place stand one above the other, white those without a check.
The films are the same for every study.
"""

import matplotlib as mpl
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from reporting.figures.parts import style

INPUTS = {
    "table": "numerics/stability.csv",
}
MARKERS = {"solved": "o", "unchecked": "D", "refused": "s", "failed": "X"}
EPSILON_TICKS = (0.001, 0.01, 0.1, 0.5, 0.9, 0.99)
LARGEST_EPSILON = 0.998
APART = 0.25
"""Of films in one place, in decades of σ."""


def draw(data: pd.DataFrame) -> Figure:
    """Left the films without inertia over (ε, σ), right those with it over (Re, σ)."""
    style.check_known(MARKERS, data["verdict"], what="verdict")
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=4.4)
    left, right = figure.subplots(1, 2, width_ratios=(3, 2), sharey=True)
    moving = data["reynolds"] > 0
    shown = _films(left, data[~moving].assign(x=data["epsilon"].clip(upper=LARGEST_EPSILON)))
    left.set_xscale("logit")
    left.set_xticks(EPSILON_TICKS, [f"{tick:g}" for tick in EPSILON_TICKS])
    left.set_xlim(4e-4, 0.9988)
    left.set_xlabel("excursion ratio ε (–); contact at the right edge")
    left.set_ylabel("squeeze number σ (–)")
    left.set_title("(a) without inertia")
    _films(right, data[moving].sort_values("epsilon", kind="stable").assign(x=data["reynolds"]))
    right.set_xscale("log")
    right.set_xlim(0.2, 120)
    right.set_xlabel("modified Reynolds number Re (–)")
    right.set_title("(b) with inertia, ε rising upwards")
    bar = figure.colorbar(shown, ax=(left, right), pad=0.01, aspect=40)
    bar.set_label("worst deviation over what is allowed (–)")
    for verdict, count in data["verdict"].value_counts().items():
        marker = MARKERS[str(verdict)]
        left.plot([], [], marker, color="0.4", linestyle="", label=f"{verdict} ({count})")
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    style.add_note(figure, data)
    return figure


def _films(axes: Axes, films: pd.DataFrame) -> PathCollection:
    """Dots coloured by the worst deviation, those of one place apart; the last of them."""
    place = films.groupby(["x", "sigma"])
    rank = place.cumcount() - (place["x"].transform("size") - 1) / 2
    films = films.assign(y=films["sigma"] * 10 ** (APART * rank))
    for verdict, marker in MARKERS.items():
        some = films[films["verdict"] == verdict]
        dots = axes.scatter(
            some["x"],
            some["y"],
            c=some["worst_over_allowed"],
            marker=marker,
            s=26,
            cmap=mpl.colormaps[style.SEQUENTIAL].with_extremes(bad="white"),
            norm=LogNorm(1e-4, 1.0, clip=True),
            plotnonfinite=True,
            edgecolors="0.3",
            linewidths=0.6,
        )
    axes.set_yscale("log")
    axes.grid(True)
    return dots
