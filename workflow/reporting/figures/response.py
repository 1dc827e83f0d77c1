"""How the force follows an amplitude that changes, and how fast."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reporting.figures import style
from reporting.figures.axes import grid_of, label_plane, not_known, show_grid
from reporting.figures.tables import in_micrometres
from reporting.results import Results

MAPS = {
    "corner_hz": "(a) corner frequency (Hz)",
    "prompt_percent": "(b) force at once (%)",
}
LINES = {
    "gain": ("(c) gain", "change of the force, relative,\nper that of the amplitude (–)"),
    "phase_deg": ("(d) phase", "force behind amplitude (°)"),
}
COLOURS = (style.BLUE, style.GREEN, style.VERMILLION)
MOST_ERROR = 0.03
"""Of a gain that is drawn."""


def response(results: Results) -> Figure:
    """Two maps of gap and amplitude above lines over the frequency of modulation."""
    maps = _read(results, "response", "status")
    for name in ("corner_hz", "prompt_share"):
        maps[name] = maps.get(name, np.nan)
    maps["prompt_percent"] = 100 * maps["prompt_share"]
    lines = _read(results, "gains", "frequency_hz", "gain", "phase_deg", "error")
    lines = lines[(lines["hv_um"] == lines["hv_um"].max()) & (lines["error"] <= MOST_ERROR)]
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=4.6)
    panels = list(figure.subplots(2, 2).flat)
    for axes, (name, title) in zip(panels[:2], MAPS.items(), strict=True):
        _draw_map(axes, maps, name)
        axes.set_title(title)
    for axes, (name, (title, label)) in zip(panels[2:], LINES.items(), strict=True):
        _draw_lines(axes, lines, name)
        axes.set(title=title, ylabel=label)
    unknown = maps.loc[maps["corner_hz"].isna(), "status"].str.removeprefix("not supported: ")
    note = ""
    if len(unknown):
        reason = unknown.iloc[0].split(" (")[0]
        note = f"Not known of {len(unknown)} of {len(maps)} films: {reason}."
    style.add_note(figure, note, results.beyond)
    return figure


def _read(results: Results, name: str, *columns: str) -> pd.DataFrame:
    file = f"simulations/screen/{name}.csv"
    return in_micrometres(results.table(file, "h0_m", "hv_m", *columns))


def _draw_map(axes: Axes, maps: pd.DataFrame, name: str) -> None:
    grid = grid_of(maps, name)
    label_plane(axes)
    show_grid(axes, grid)
    known = maps[maps[name].notna()]
    if known.empty:
        _nothing(axes)
        return
    if min(known["h0_um"].nunique(), known["hv_um"].nunique()) < 2:  # no lines between films
        axes.plot(known["h0_um"], known["hv_um"], "k.", markersize=3)
        for h0_um, hv_um, value in known[["h0_um", "hv_um", name]].to_numpy():
            axes.text(h0_um, hv_um, f"  {value:.3g}", fontsize=6, va="center")
        axes.margins(0.05)
        axes.autoscale()
        return
    lines = axes.contour(
        *grid[:2], np.ma.masked_invalid(grid[2]), levels=7, colors="black", linewidths=0.9
    )
    axes.clabel(lines, fontsize=6, fmt="%.4g")


def _nothing(axes: Axes) -> None:
    """Neither lines nor numbers: an empty scale would look like a result."""
    not_known(axes)
    axes.set(xticks=[], yticks=[])
    axes.grid(False)


def _draw_lines(axes: Axes, lines: pd.DataFrame, name: str) -> None:
    """One line for each of three gaps, named at its end."""
    gaps = sorted(lines["h0_um"].unique())
    if not gaps:
        _nothing(axes)
        return
    axes.set(xscale="log", xlabel="frequency of modulation (Hz)")
    axes.grid(True)
    chosen = dict.fromkeys(gaps[index] for index in (0, len(gaps) // 2, -1))
    for gap, colour in zip(chosen, COLOURS, strict=False):
        line = lines[lines["h0_um"] == gap].sort_values("frequency_hz")
        axes.plot(line["frequency_hz"], line[name], color=colour, label=f"{gap:.3g} µm")
    if name == "gain":
        axes.legend(title="$h_0$", fontsize=6, title_fontsize=6)
