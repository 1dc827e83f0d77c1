"""Figures 9 to 11: where the searches for a D-optimal design end, and their patterns."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reporting.figures import style
from reporting.figures.axes import dots, label_points, set_up_plane
from reporting.figures.tables import add_limits, in_micrometres, micrometres
from reporting.notes import one_digit
from reporting.results import Results

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


def fig09(results: Results) -> tuple[Figure, pd.DataFrame]:
    """A panel for each scaling of the factors; a triangle of three dots for each search."""
    summary = results.searches()
    columns = ("scaling", "search", "pattern", "h0_m", "hv_m", "objective")
    points = in_micrometres(results.table("designs/two_factor_searches.csv", *columns))
    data = points[["scaling", "search", "pattern", "h0_um", "hv_um", "objective"]].sort_values(
        "scaling", key=lambda names: names != summary["scaling"], kind="stable"
    )
    data = add_limits(data, results.scenes("screen"))
    scalings = data["scaling"].unique()
    wide = len(scalings) > 1
    width = style.DOUBLE_COLUMN_IN if wide else style.SINGLE_COLUMN_IN
    figure = style.new_figure(width_in=width, height_in=2.75)
    panels = figure.subplots(1, len(scalings), squeeze=False, sharey=True)[0]
    for letter, axes, scaling in zip("abcdefgh", panels, scalings, strict=False):
        _draw_searches(axes, data[data["scaling"] == scaling])
        set_up_plane(axes, data)
        axes.set_title(f"({letter}) " * wide + _TITLES[scaling])
        axes.label_outer()
    note = f"{summary['searches']} searches in each unit of the distances in criterion (12)."
    style.add_note(figure, note, results.beyond)
    return figure, data


def _draw_searches(axes: Axes, data: pd.DataFrame) -> None:
    searches = data["search"].nunique()
    for order, (pattern, found) in enumerate(data.groupby("pattern", sort=True)):
        colour, marker = _LOOKS[order % len(_LOOKS)]

        triplets = [pd.concat([each, each.iloc[:1]]) for _, each in found.groupby("search")]
        lines = axes.plot(
            np.column_stack([each["h0_um"] for each in triplets]),
            np.column_stack([each["hv_um"] for each in triplets]),
            color=colour,
            linewidth=0.5,
            linestyle=(0, (4, 2)) if order else "-",
            marker=marker,
            markersize=7 - 2 * min(order, 2),
            markerfacecolor="none" if order == 0 else colour,
            markeredgewidth=0.8,
            zorder=2 + order,
        )
        lines[0].set_label(f"{pattern}: {found['search'].nunique()} of {searches} searches")
    axes.legend(loc="lower left", handlelength=1.6, labelspacing=0.3)


def fig10(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The first pattern of the study's own scaling."""
    return _pattern(results, order=0)


def fig11(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The second pattern, if the searches ended in one."""
    return _pattern(results, order=1)


def pattern_table(results: Results, *, order: int) -> tuple[pd.DataFrame, str]:
    """Data of one pattern of the study's own scaling, the best being of order 0, and a note.

    Layers design (its points) and ridge (equal hv/h0 through a point, within the space); where
    there are fewer patterns, a row of layer absent.
    """
    screen = results.scenes("screen")
    summary = results.searches()
    number, patterns = summary["searches"], summary["scalings"][summary["scaling"]]
    columns = ["layer", "epsilon", "h0_um", "hv_um"]
    if order >= len(patterns):
        found = ", ".join(f"{each['pattern']} ({each['count']})" for each in patterns)
        absent = pd.DataFrame([{"layer": "absent"}], columns=columns)
        note = f"All {number} searches ended in other patterns: {found}."
        return add_limits(absent, screen), note
    pattern = patterns[order]
    rows = []
    for point in pattern["points"]:
        epsilon = point["hv_m"] / point["h0_m"]
        rows.append(("design", epsilon, point["h0_m"], point["hv_m"]))
        lowest = max(screen["h0_m"].min(), screen["hv_m"].min() / epsilon)
        highest = min(screen["h0_m"].max(), screen["hv_m"].max() / epsilon)
        ridge = np.linspace(lowest, highest, 11)
        rows += [("ridge", epsilon, h0_m, epsilon * h0_m) for h0_m in ridge]
    data = pd.DataFrame(rows, columns=columns)
    data["h0_um"], data["hv_um"] = micrometres(data["h0_um"]), micrometres(data["hv_um"])
    note = (
        f"Pattern {pattern['pattern']}: {pattern['count']} of {number} searches; O = "
        f"{pattern['objective']:.7g}"
    )
    if order:
        behind = pattern["objective_excess"] / patterns[0]["objective"]
        note += f", {one_digit(behind)} above A in proportion"
    return add_limits(data, screen), f"{note}."


def _pattern(results: Results, *, order: int) -> tuple[Figure, pd.DataFrame]:
    """Three dots and the lines of equal hv/h0 through them, along which the model is the same."""
    data, note = pattern_table(results, order=order)
    figure = style.new_figure()
    axes = figure.subplots()
    for _, line in style.rows(data, "ridge").groupby("epsilon"):
        axes.plot(line["h0_um"], line["hv_um"], color="0.55", linestyle=(0, (4, 2)), linewidth=0.9)
    design = style.rows(data, "design")
    dots(axes, design, fill="black", markersize=6, zorder=3)
    set_up_plane(axes, data, headroom=0.3)
    labels = [
        f"({h0:.3g}, {hv:.3g}) µm\n$h_v/h_0$ = {epsilon:.3f}"
        for h0, hv, epsilon in zip(design["h0_um"], design["hv_um"], design["epsilon"], strict=True)
    ]
    label_points(axes, design, labels=labels)
    if design.empty:
        text = "no such pattern:\nall searches ended in the\npatterns shown before"
        axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center")
    style.add_note(figure, note, results.beyond)
    return figure, data
