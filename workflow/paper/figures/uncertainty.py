"""Uncertainty: what would explain the difference from the paper's force.

The force for which the paper states 0.99 N, with each assumption of the simulation changed alone.
Left: over its relative change; thick where a value is plausible. Right: over the plausible values.
Grey: what the paper's digits may stand for.
"""

from collections.abc import Callable
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import style
from reporting.figures.parts.tables import Inputs
from squeezefilm.config.loading import Config
from squeezefilm.io.sources import read_columns

INPUTS = {
    "table": "tables/uncertainty.csv",
    "curves": "tables/uncertainty_curves.csv",
}
SHOWN = "simulation_at_2.2"
COLOURS = (style.VERMILLION, style.BLUE, style.GREEN, style.ORANGE, style.PURPLE, "black")


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers curve (force over the change of one assumption) and range (over plausible values)."""
    columns = ("claim_id", "claim", "assumption", "verdict", "force_low_n", "force_high_n")
    table = read_columns(inputs["table"], columns=columns)
    curves = read_columns(inputs["curves"], columns=("claim_id", "assumption", "change_percent"))
    table = table[table["claim_id"] == SHOWN]
    curves = curves[curves["claim_id"] == SHOWN]
    first = table.iloc[0]
    explaining = list(table.loc[table["verdict"] == "explains", "assumption"])
    data = pd.concat(
        [
            curves[["assumption", "change_percent", "plausible", "force_n"]].assign(layer="curve"),
            table[["assumption", "force_low_n", "force_high_n", "verdict"]].assign(layer="range"),
        ],
        ignore_index=True,
    )
    note = (
        f"{first['claim'].capitalize()}, each assumption changed alone and the force simulated "
        f"anew: {first['ours_n']:.3f} N with those of this study, {first['paper_n']:g} N in the "
        "paper (grey: what rounds to that). Thick, and on the right: plausible values. "
        + (
            f"What explains the difference: {', '.join(explaining)}."
            if explaining
            else "None of them explains the difference."
        )
    )
    limits = {name: first[name] for name in ("paper_n", "paper_low_n", "paper_high_n", "ours_n")}
    return data.assign(**limits, note=note)


def draw(data: pd.DataFrame) -> Figure:
    """Left, layer curve: force over change; right, layer range: force over plausible values."""
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=3.1)
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.05))
    first = data.iloc[0]
    ranges, curves = style.rows(data, "range"), style.rows(data, "curve")
    names = list(ranges["assumption"])
    shown = [name for name in names if name in set(curves["assumption"])]
    colours = dict(zip(shown, COLOURS, strict=False))
    for name in shown:
        curve = curves[curves["assumption"] == name]
        plausible = curve[curve["plausible"].astype(bool)]
        colour = colours.get(name, style.GREY)
        left.plot(curve["change_percent"], curve["force_n"], color=colour, label=name)
        left.plot(
            plausible["change_percent"],
            plausible["force_n"],
            color=colour,
            linewidth=3.5,
            solid_capstyle="butt",
        )
    left.plot(0, first["ours_n"], "o", color="black", markersize=4, zorder=5)
    _paper(left.axhspan, left.axhline, first)
    left.set_xlim(curves["change_percent"].min(), curves["change_percent"].max())
    left.set_xlabel("change of the assumption (%)")
    left.set_ylabel("force (N)")
    left.grid(True)
    left.annotate(
        "paper",
        (0, first["paper_high_n"]),
        xycoords=("axes fraction", "data"),
        xytext=(8, 2),
        textcoords="offset points",
        fontsize=6,
    )
    figure.legend(loc="outside upper center", ncols=len(shown), fontsize=6, columnspacing=1.2)
    for place, row in enumerate(ranges.itertuples()):
        colour = colours.get(row.assumption, style.GREY)
        ends = (row.force_low_n, row.force_high_n)
        right.plot(ends, (place, place), color=colour, linewidth=6, solid_capstyle="butt")
        right.plot(ends, (place, place), "|", color=colour, markersize=6)
    right.axvline(first["ours_n"], color="black", linewidth=0.8, linestyle=":")
    _paper(right.axvspan, right.axvline, first)
    right.set_yticks(
        range(len(ranges)),
        [f"{row.assumption}:\n{row.verdict}" for row in ranges.itertuples()],
        fontsize=6,
    )
    right.set_ylim(len(ranges) - 0.5, -0.5)
    right.set_xlabel("force over the plausible values (N)")
    right.grid(True, axis="x")
    style.add_note(figure, data)
    return figure


def _paper(span: Callable[..., Any], line: Callable[..., Any], first: pd.Series) -> None:
    """The paper's force, and what rounds to it."""
    span(first["paper_low_n"], first["paper_high_n"], color="0.88", zorder=0)
    line(first["paper_n"], color="0.35", linewidth=0.8)
