"""What the film equation itself leaves out of the force, over gap and amplitude and position."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from reporting.figures import style
from reporting.figures.axes import beside, grid_of, label_plane, not_known, show_grid
from reporting.figures.tables import in_micrometres, micrometres
from reporting.results import Results
from squeezefilm.solution import form_of

EFFECTS = {
    "inertia": (style.BLUE, "inertia"),
    "slip": (style.VERMILLION, "slip"),
    "heat": (style.ORANGE, "heat"),
    "rim": (style.GREEN, "rim, C = 1"),
    "left_out": (style.GREY, "left out in all"),
}
EDGE = 0.04
"""Contours nearer to the least or the largest value, as a share of the range, have no room."""
LABEL_SHARE = 0.065
"""Height of a label, as a share of the axes."""
ON_DISC, ON_RECTANGLE = ("phi_r_mm", "phi_deg"), ("x_mm", "y_mm")


def budget(results: Results) -> Figure:
    """A map for each effect and for their sum, and lines over the position."""
    screen = _read(results, "screen")
    positions = _read(results, "four_factor")
    largest = positions["hv_um"] / positions["h0_um"]
    along = positions[largest >= largest.max() * (1 - 1e-9)]
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=4.3)
    panels = list(figure.subplots(2, 3).flat)
    for letter, axes, name in zip("abcde", panels, EFFECTS, strict=False):
        _draw_map(axes, screen, name)
        axes.set_title(f"({letter}) {EFFECTS[name][1]} (%)")
        label_plane(axes)
    places = ON_DISC if "phi_deg" in positions else ON_RECTANGLE
    _draw_lines(panels[-1], along, places)
    panels[-1].set_title(f"(f) along {'the radius' if 'phi_deg' in places else 'x'}")
    present = screen["in_force"].iloc[0]
    note = f"(f): h0 = {along['h0_um'].iloc[0]:.3g} µm, hv = {along['hv_um'].iloc[0]:.3g} µm."
    if isinstance(present, str):
        note += f" In the forces already: {present}."
    style.add_note(figure, note, results.beyond)
    return figure


def _read(results: Results, plan: str) -> pd.DataFrame:
    file = f"simulations/{plan}/budget.csv"
    columns = ("h0_m", "hv_m", "phi_r_m", "phi_deg", "above_range", "in_force")
    table = results.table(file, *columns)
    lengths = [name for name in form_of(table) if name.endswith("_m")]
    middle = (table["left_out_least_percent"] + table["left_out_most_percent"]) / 2
    return in_micrometres(table).assign(
        **{f"{name[:-1]}mm": micrometres(table[name]) / 1e3 for name in lengths},
        left_out_percent=middle,
        above_range=table["above_range"].fillna(""),
    )


def _draw_map(axes: Axes, maps: pd.DataFrame, name: str) -> None:
    """Contour lines of one effect, in its colour; dashed where some of it is above its range."""
    grid = grid_of(maps, f"{name}_percent")
    show_grid(axes, grid)
    if not np.isfinite(grid[2]).any():
        not_known(axes)
        return
    above = maps["above_range"].str.split("; ").map(lambda names: name in names)
    low, high = float(np.nanmin(grid[2])), float(np.nanmax(grid[2]))
    edge = EDGE * (high - low)
    ticks = MaxNLocator(nbins=8).tick_values(low, high)
    levels = [level for level in ticks if low + edge <= level <= high - edge] or [low]
    lines = axes.contour(
        *grid,
        levels=levels,
        colors=EFFECTS[name][0],
        linestyles="dashed" if above.any() else "solid",
        linewidths=0.9,
    )
    axes.clabel(lines, fontsize=6, fmt=lambda level: f"{level:+.3g}".replace("-", "−"))


def _name_ends(axes: Axes, ends: Sequence[tuple[float, str, str]], *, at: float) -> None:
    """A name beside each line's end, from the lowest up and none over another."""
    low, high = axes.get_ylim()
    last = -np.inf
    for value, text, colour in sorted(ends):
        last = max(value, last + LABEL_SHARE * (high - low))
        beside(axes, text, (at, last), (6, 0), va="center", color=colour, fontsize=6)


def _draw_lines(axes: Axes, rows: pd.DataFrame, places: tuple[str, str]) -> None:
    """Each effect over the first coordinate, for the least of the other and for the largest."""
    place, other = places
    rows = rows.drop_duplicates(list(places)).sort_values(place)
    off = rows[rows[place] != 0]
    least, farthest = min(0.0, float(rows[place].min())), float(rows[place].max())
    ends: list[tuple[float, str, str]] = []
    for marker, value in (("o", off[other].min()), ("s", off[other].max())):
        at_centre = (rows[place] == 0) & (other == "phi_deg")
        along = rows[at_centre | (rows[other] == value)].drop_duplicates(place)
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
    label = r"radial position $\phi_r$ (mm)" if other == "phi_deg" else "$x$ (mm)"
    axes.set(xlabel=label, ylabel="change of the force (%)")
    axes.grid(True)
