"""What would explain the difference from the paper's force, each assumption changed alone."""

from collections.abc import Callable
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures import style
from reporting.figures.axes import beside
from reporting.results import Results

SHOWN = "simulation_at_2.2"
COLOURS = (style.VERMILLION, style.BLUE, style.GREEN, style.ORANGE, style.PURPLE, "black")


def uncertainty(results: Results) -> Figure:
    """Left, force over the change of an assumption; right, over its plausible values."""
    columns = ("claim_id", "claim", "assumption", "verdict", "force_low_n", "force_high_n")
    ranges = results.table("tables/uncertainty.csv", *columns)
    curves = results.table("tables/uncertainty_curves.csv", "claim_id", "assumption", "force_n")
    ranges, curves = (table[table["claim_id"] == SHOWN] for table in (ranges, curves))
    first = ranges.iloc[0]
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=3.1)
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.05))
    shown = [name for name in ranges["assumption"] if name in set(curves["assumption"])]
    colours = dict(zip(shown, COLOURS, strict=False))
    for name in shown:
        curve = curves[curves["assumption"] == name]
        plausible = curve[curve["plausible"].astype(bool)]
        colour = colours.get(name, style.GREY)
        left.plot(curve["change_percent"], curve["force_n"], color=colour, label=name)
        thick = {"linewidth": 3.5, "solid_capstyle": "butt"}
        left.plot(plausible["change_percent"], plausible["force_n"], color=colour, **thick)
    left.plot(0, first["ours_n"], "o", color="black", markersize=4, zorder=5)
    _paper(left.axhspan, left.axhline, first)
    left.set_xlim(curves["change_percent"].min(), curves["change_percent"].max())
    left.set(xlabel="change of the assumption (%)", ylabel="force (N)")
    left.grid(True)
    rim, coordinates = (0, first["paper_high_n"]), ("axes fraction", "data")
    beside(left, "paper", rim, (8, 2), xycoords=coordinates, fontsize=6)
    figure.legend(loc="outside upper center", ncols=len(shown), fontsize=6, columnspacing=1.2)
    for place, row in enumerate(ranges.itertuples()):
        colour = colours.get(row.assumption, style.GREY)
        ends = (row.force_low_n, row.force_high_n)
        right.plot(ends, (place, place), color=colour, linewidth=6, solid_capstyle="butt")
        right.plot(ends, (place, place), "|", color=colour, markersize=6)
    right.axvline(first["ours_n"], color="black", linewidth=0.8, linestyle=":")
    _paper(right.axvspan, right.axvline, first)
    names = ranges["assumption"] + ":\n" + ranges["verdict"]
    right.set_yticks(range(len(ranges)), names, fontsize=6)
    right.set_ylim(len(ranges) - 0.5, -0.5)
    right.set_xlabel("force over the plausible values (N)")
    right.grid(True, axis="x")
    note = (
        f"{first['claim'].capitalize()}: {first['ours_n']:.3f} N here, {first['paper_n']:g} N in "
        "the paper (grey: what rounds to that). Thick, and on the right: plausible values."
    )
    style.add_note(figure, note, results.beyond)
    return figure


def _paper(span: Callable[..., Any], line: Callable[..., Any], first: pd.Series) -> None:
    """The paper's force, and what rounds to it."""
    span(first["paper_low_n"], first["paper_high_n"], color="0.88", zorder=0)
    line(first["paper_n"], color="0.35", linewidth=0.8)
