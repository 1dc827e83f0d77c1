"""Figure 9: where the searches for an optimal design end.

The three points that each search for a D-optimal design ended in, joined to a triangle. One panel
for each unit in which the distances of criterion (12) can be taken; the outcome depends on it.
"""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from paper.figures.parts import patterns
from reporting.figures.parts import plane, style
from reporting.figures.parts.tables import Inputs, add_limits, micrometres
from reporting.pages.notes import one_digit
from squeezefilm.config.loading import Config
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import read_scenes

INPUTS = {
    "plan": "simulations/screen/scenes.csv",
    "searches": "designs/two_factor_searches.csv",
    "summary": "designs/two_factor.json",
}
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


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """One row per point of each search, the study's own scaling first."""
    own, number, scalings = patterns.patterns_found(inputs["summary"])
    columns = ("scaling", "search", "pattern", "h0_m", "hv_m", "objective")
    points = read_columns(inputs["searches"], columns=columns)
    data = pd.DataFrame(
        {
            "scaling": points["scaling"],
            "search": points["search"],
            "pattern": points["pattern"],
            "h0_um": micrometres(points["h0_m"]),
            "hv_um": micrometres(points["hv_m"]),
            "objective": points["objective"],
        }
    ).sort_values("scaling", key=lambda names: names != own, kind="stable")
    least = scalings[own][0]["objective"]
    behind = [
        f"{pattern['pattern']} {one_digit(pattern['objective_excess'] / least)}"
        for pattern in scalings[own][1:]
    ]
    excess = f" O above that of A, in proportion: {', '.join(behind)} in (a)." if behind else ""
    note = (
        f"{number} searches on criterion (12) in each unit of the distances between points, which "
        f"the paper does not state; (a) is used further on.{excess} Letters are given anew in each "
        "panel."
    )
    return add_limits(data, read_scenes(inputs["plan"])).assign(note=note)


def draw(data: pd.DataFrame) -> Figure:
    """A panel for each scaling of the factors; a triangle of three dots for each search."""
    scalings = list(dict.fromkeys(data["scaling"]))
    style.check_known(_TITLES, scalings, what="scaling")
    wide = len(scalings) > 1
    figure = style.new_figure(
        width_in=style.DOUBLE_COLUMN_IN if wide else style.SINGLE_COLUMN_IN, height_in=2.75
    )
    panels = figure.subplots(1, len(scalings), squeeze=False, sharey=True)[0]
    for letter, axes, scaling in zip("abcdefgh", panels, scalings, strict=False):
        _draw_searches(axes, data[data["scaling"] == scaling])
        plane.set_up(axes, data)
        axes.set_title(f"({letter}) " * wide + _TITLES[scaling])
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
