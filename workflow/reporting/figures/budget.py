"""Budget: what the film equation itself leaves out of the force.

Each effect on the mean force at first order, in per cent of it: maps over gap and amplitude for a
centred finger, and lines over the finger's distance from the centre, or over x on a rectangle, at
the smallest gap and largest amplitude of that plan. The loss of pressure where gas streams in at
the rim is known up to a coefficient C; it is shown for C = 1, the sum of all that the force does
not have by the middle of its band. Dashed maps are of effects too large somewhere for a first
order.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from reporting.figures.parts import plane, style
from reporting.figures.parts.tables import Inputs, micrometres
from squeezefilm.config.loading import Config
from squeezefilm.io.positions import form_of
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import THIS_SCENE

INPUTS = {
    "plane": "simulations/screen/budget.csv",
    "positions": "simulations/four_factor/budget.csv",
}
EFFECTS = {
    "inertia": (style.BLUE, "inertia"),
    "slip": (style.VERMILLION, "slip"),
    "heat": (style.ORANGE, "heat"),
    "rim": (style.GREEN, "rim, C = 1"),
    "left_out": (style.GREY, "left out in all"),
}
# Contours nearer to the least or the largest value, in shares of the range, have no room.
EDGE = 0.04
# Height of a label, as a share of the axes.
LABEL_SHARE = 0.065
ON_DISC, ON_RECTANGLE = ("phi_r_mm", "phi_deg"), ("x_mm", "y_mm")
COLUMNS = (
    "layer",
    "h0_um",
    "hv_um",
    *(f"{name}_percent" for name in EFFECTS),
    "above_range",
    "note",
)


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers plane (the screen) and radius (the four-factor plan's point of the largest ε)."""
    screen, positions = (_read(inputs[name]) for name in INPUTS)
    largest = positions["hv_um"] / positions["h0_um"]
    chosen = positions[largest >= largest.max() * (1 - 1e-9)]
    first = chosen.iloc[0]
    places = ON_DISC if "phi_deg" in positions else ON_RECTANGLE
    other = "direction" if "phi_deg" in places else "y"
    note = (
        f"Maps: finger at the centre. (f): h0 = {first['h0_um']:.3g} µm, "
        f"hv = {first['hv_um']:.3g} µm, open circles the least {other} of the plan, squares the "
        "largest. (e): the middle of the band that C = 1 to 1.54 and higher orders make. First "
        "order about the film without inertia, on coarse grids."
    )
    if (screen["above_range"] != "").any():
        note += " Dashed: somewhere too large for a first order, which is then too much."
    if isinstance(present := screen["in_force"].iloc[0], str):
        note += f" In the forces already: {present}."
    if screen["basis"].iloc[0] != THIS_SCENE:
        note += f" Estimates, of {screen['basis'].iloc[0]}."
    return pd.concat(
        [screen.assign(layer="plane"), chosen.assign(layer="radius")], ignore_index=True
    ).assign(note=note)[[*COLUMNS[:3], *places, *COLUMNS[3:]]]


def _read(path: Any) -> pd.DataFrame:
    table = read_columns(
        path, columns=("h0_m", "hv_m", "phi_r_m", "phi_deg", "above_range", "in_force", "basis")
    )
    places = {
        f"{name[:-1]}mm": micrometres(table[name]) / 1e3
        for name in form_of(table)
        if name.endswith("_m")
    }
    middle = (table["left_out_least_percent"] + table["left_out_most_percent"]) / 2
    return table.assign(
        h0_um=micrometres(table["h0_m"]),
        hv_um=micrometres(table["hv_m"]),
        **places,
        left_out_percent=middle,
        above_range=table["above_range"].fillna(""),
    )


def draw(data: pd.DataFrame) -> Figure:
    """A map for each effect and for what is left out in all, and lines over the position."""
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=4.3)
    panels = list(figure.subplots(2, 3).flat)
    maps = style.rows(data, "plane")
    for letter, axes, name in zip("abcde", panels, EFFECTS, strict=False):
        _draw_map(axes, maps, name)
        axes.set_title(f"({letter}) {EFFECTS[name][1]} (%)")
        axes.set_xlabel(plane.H0_LABEL)
        axes.set_ylabel(plane.HV_LABEL)
    places = ON_DISC if "phi_deg" in data else ON_RECTANGLE
    _draw_lines(panels[-1], style.rows(data, "radius"), places)
    panels[-1].set_title(f"(f) along {'the radius' if 'phi_deg' in places else 'x'}")
    style.add_note(figure, data)
    return figure


def _draw_map(axes: Any, maps: pd.DataFrame, name: str) -> None:
    """Contour lines of one effect, in its colour; dashed where some of it is above its range."""
    table = maps.pivot(index="hv_um", columns="h0_um", values=f"{name}_percent")
    values = table.to_numpy()
    axes.set_xlim(table.columns.min(), table.columns.max())
    axes.set_ylim(table.index.min(), table.index.max())
    if not np.isfinite(values).any():
        axes.text(0.5, 0.5, "not known", transform=axes.transAxes, ha="center")
        return
    above = maps["above_range"].fillna("").str.split("; ").map(lambda names: name in names)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    edge = EDGE * (high - low)
    ticks = MaxNLocator(nbins=8).tick_values(low, high)
    levels = [level for level in ticks if low + edge <= level <= high - edge] or [low]
    lines = axes.contour(
        table.columns.to_numpy(),
        table.index.to_numpy(),
        values,
        levels=levels,
        colors=EFFECTS[name][0],
        linestyles="dashed" if above.any() else "solid",
        linewidths=0.9,
    )
    axes.clabel(lines, fontsize=6, fmt=lambda level: f"{level:+.3g}".replace("-", "−"))


def _name_ends(axes: Any, ends: Sequence[tuple[float, str, str]], *, at: float) -> None:
    """A name beside each line's end, from the lowest up and none over another."""
    low, high = axes.get_ylim()
    last = -np.inf
    for value, text, colour in sorted(ends):
        last = max(value, last + LABEL_SHARE * (high - low))
        axes.annotate(
            text,
            (at, last),
            xytext=(6, 0),
            textcoords="offset points",
            va="center",
            color=colour,
            fontsize=6,
        )


def _draw_lines(axes: Any, rows: pd.DataFrame, places: tuple[str, str]) -> None:
    """Each effect over the first coordinate, for the least of the other and for the largest."""
    place, other = places
    rows = rows.drop_duplicates(list(places)).sort_values(place)
    off = rows[rows[place] != 0]
    least, farthest = min(0.0, float(rows[place].min())), float(rows[place].max())
    ends: list[tuple[float, str, str]] = []
    for marker, value in (("o", off[other].min()), ("s", off[other].max())):
        at_centre = (rows[place] == 0) & (other == "phi_deg")
        along = rows[at_centre | (rows[other] == value)]
        along = along.drop_duplicates(place)
        for name, (colour, label) in EFFECTS.items():
            values = along[f"{name}_percent"]
            axes.plot(
                along[place],
                values,
                marker + "-",
                color=colour,
                markersize=6 if marker == "o" else 3,
                markerfacecolor="white" if marker == "o" else colour,
            )
            if marker == "s" and np.isfinite(values.iloc[-1]):
                text = label.removesuffix(", C = 1").removesuffix(" in all")
                ends.append((float(values.iloc[-1]), text, colour))
    _name_ends(axes, ends, at=farthest)
    axes.set_xlim(least - 0.05 * farthest, farthest + 0.35 * (farthest - least) or 1.0)
    axes.axhline(0, color="black", linewidth=0.5)
    axes.set_xlabel(r"radial position $\phi_r$ (mm)" if other == "phi_deg" else "$x$ (mm)")
    axes.set_ylabel("change of the force (%)")
    axes.grid(True)
