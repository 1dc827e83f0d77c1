"""Figures 9 to 11: where the searches for a D-optimal design end, and their patterns."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squeezefilm_workflow.reporting.figures import parts, style
from squeezefilm_workflow.reporting.results import Results

_COLOURS = (style.BLUE, style.VERMILLION, style.GREEN, style.PURPLE, style.ORANGE)
_COLOUR_AND_MARKER = tuple(zip(_COLOURS, "o^sDv", strict=True))
_TITLE_OF_SCALING = {
    "unit": "factors scaled to [0, 1]",
    "micrometre": "factors in µm",
    "metre": "factors in m",
}


def fig09(results: Results) -> tuple[Figure, pd.DataFrame]:
    """A panel for each scaling of the factors; a triangle of three dots for each search."""
    summary, screen = results.read_json_file("designs/two_factor.json"), results.scenes("screen")
    columns = ("scaling", "search", "pattern", "h0_m", "hv_m", "objective")
    points = parts.with_micrometre_columns(
        results.table("designs/two_factor_searches.csv", *columns)
    )
    data = points[["scaling", "search", "pattern", "h0_um", "hv_um", "objective"]].sort_values(
        "scaling", key=lambda names: names != summary["scaling"], kind="stable"
    )
    scalings = data["scaling"].unique()
    wide = len(scalings) > 1
    figure = style.new_figure(wide=wide, height_in=2.75)
    panels = figure.subplots(1, len(scalings), squeeze=False, sharey=True)[0]
    for letter, axes, scaling in zip("abcdefgh", panels, scalings, strict=False):
        _draw_design_triangles(axes, data[data["scaling"] == scaling])
        parts.set_up_gap_amplitude_axes(axes, screen)
        axes.set_title(f"({letter}) " * wide + _TITLE_OF_SCALING[scaling])
        axes.label_outer()
    note = f"{summary['searches']} searches in each unit of the distances in criterion (12)."
    style.add_note(figure, note, results.validity_note)
    return figure, data


def _draw_design_triangles(axes: Axes, data: pd.DataFrame) -> None:
    searches = data["search"].nunique()
    for order, (pattern, searches_of_pattern) in enumerate(data.groupby("pattern", sort=True)):
        colour, marker = _COLOUR_AND_MARKER[order % len(_COLOUR_AND_MARKER)]

        triplets = [
            pd.concat([triplet, triplet.iloc[:1]])
            for _, triplet in searches_of_pattern.groupby("search")
        ]
        lines = axes.plot(
            np.column_stack([triplet["h0_um"] for triplet in triplets]),
            np.column_stack([triplet["hv_um"] for triplet in triplets]),
            color=colour,
            linewidth=0.5,
            linestyle=style.DASHED_LINE if order else "-",
            marker=marker,
            markersize=7 - 2 * min(order, 2),
            markerfacecolor="none" if order == 0 else colour,
            markeredgewidth=0.8,
            zorder=2 + order,
        )
        lines[0].set_label(
            f"{pattern}: {searches_of_pattern['search'].nunique()} of {searches} searches"
        )
    axes.legend(loc="lower left", handlelength=1.6, labelspacing=0.3)


def fig10(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The first pattern of the study's own scaling."""
    return _draw_pattern(results, order=0)


def fig11(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The second pattern, if the searches ended in one."""
    return _draw_pattern(results, order=1)


def _draw_pattern(results: Results, *, order: int) -> tuple[Figure, pd.DataFrame]:
    """Three dots and the lines of equal hv/h0 through them, along which the model is the same.

    Its table has the layers design (the points) and ridge (equal hv/h0 through a point, within the
    space); where there are fewer patterns, the best being of order 0, a row of layer absent.
    """
    screen, summary = results.scenes("screen"), results.read_json_file("designs/two_factor.json")
    number, patterns = summary["searches"], summary["scalings"][summary["scaling"]]
    figure, axes = style.subplots()
    parts.set_up_gap_amplitude_axes(axes, screen, headroom=0.3)
    if order >= len(patterns):
        other_patterns = ", ".join(
            f"{pattern_row['pattern']} ({pattern_row['count']})" for pattern_row in patterns
        )
        note = f"All {number} searches ended in other patterns: {other_patterns}."
        style.add_note(figure, note, results.validity_note)
        text = "no such pattern:\nall searches ended in the\npatterns shown before"
        axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center")
        absent = pd.DataFrame([{"layer": "absent"}])
        return figure, absent.reindex(columns=["layer", "epsilon", "h0_um", "hv_um"])
    pattern, layers = patterns[order], []
    for point in pattern["points"]:
        epsilon = point["hv_m"] / point["h0_m"]
        lowest = max(screen["h0_m"].min(), screen["hv_m"].min() / epsilon)
        highest = min(screen["h0_m"].max(), screen["hv_m"].max() / epsilon)
        h0_m = np.array([point["h0_m"], *np.linspace(lowest, highest, 11)])
        line = pd.DataFrame({"layer": "ridge", "epsilon": epsilon, "h0_m": h0_m})
        line.loc[0, "layer"] = "design"
        layers.append(parts.with_micrometre_columns(line.assign(hv_m=epsilon * h0_m)))
        ridge = layers[-1][1:]
        look = {"color": "0.55", "linestyle": style.DASHED_LINE, "linewidth": 0.9}
        axes.plot(ridge["h0_um"], ridge["hv_um"], **look)
    data = pd.concat(layers, ignore_index=True)[["layer", "epsilon", "h0_um", "hv_um"]]
    design = style.layer_rows(data, "design")
    parts.draw_dots(axes, design, fill="black", markersize=6, zorder=3)
    labels = [
        f"({row.h0_um:.3g}, {row.hv_um:.3g}) µm\n$h_v/h_0$ = {row.epsilon:.3f}"
        for row in design.itertuples()
    ]
    parts.label_points(axes, design, labels=labels)
    count = f"Pattern {pattern['pattern']}: {pattern['count']} of {number} searches."
    measure = f"force in N, {_TITLE_OF_SCALING[summary['scaling']]}"
    note = f"Criterion (12), {measure}: {pattern['objective']:.7g}"
    if order:
        behind = pattern["objective_excess"] / patterns[0]["objective"]
        note += f", {behind:.0e} above A in proportion"
    style.add_note(figure, count, f"{note}.", "Dashed: hv/h0 as at a point.", results.validity_note)
    return figure, data
