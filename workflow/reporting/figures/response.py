"""Response: how the force follows an amplitude that changes, and how fast.

Maps over gap and amplitude for a centred finger: the corner frequency of modulation, above which
the gas has no time to come and go through the rim, and the share of the settled force that is there
when the surface starts. Lines over the frequency of modulation, for the largest amplitude and
three gaps: relative change of the force per relative change of the amplitude, and the phase by
which the force lags. Texture that is felt (up to about 1 kHz) passes at every frequency; above the
corner it is weaker. White is where the film is not slow against its vibration.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import plane, style
from reporting.figures.parts.tables import Inputs, micrometres
from squeezefilm.config.loading import Config
from squeezefilm.io.sources import read_columns

INPUTS = {
    "response": "simulations/screen/response.csv",
    "gains": "simulations/screen/gains.csv",
}
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
MEASURED = ("corner_hz", "prompt_share", "error")
COLUMNS = (
    "layer",
    "h0_um",
    "hv_um",
    "corner_hz",
    "prompt_percent",
    "frequency_hz",
    "gain",
    "phase_deg",
    "error",
    "note",
)


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers plane (a row per scene) and lines (per scene and frequency)."""
    maps = _read(inputs["response"], "status")
    maps = maps.assign(**{name: np.nan for name in MEASURED if name not in maps})
    lines = _read(inputs["gains"], "frequency_hz", "gain", "phase_deg", "error")
    lines = lines[(lines["hv_um"] == lines["hv_um"].max()) & (lines["error"] <= MOST_ERROR)]
    known = maps[maps["corner_hz"].notna()]
    note = "By the slow film equation with the rim's boundary layer, without inertia and heat. "
    unknown = maps.loc[maps["corner_hz"].isna(), "status"].str.removeprefix("not supported: ")
    if len(known):
        error = 100 * known["error"].max()
        note += f"Its settled forces are up to {error:.2g} % off those of a film without these."
    if len(unknown):
        note += (
            f" Not known of {len(unknown)} of {len(maps)} films: {unknown.iloc[0].split(' (')[0]}."
        )
    return pd.concat(
        [
            maps.assign(layer="plane", prompt_percent=100 * maps["prompt_share"]),
            lines.assign(layer="lines"),
        ],
        ignore_index=True,
    ).assign(note=note)[list(COLUMNS)]


def _read(path: Any, *columns: str) -> pd.DataFrame:
    table = read_columns(path, columns=("h0_m", "hv_m", *columns))
    return table.assign(h0_um=micrometres(table["h0_m"]), hv_um=micrometres(table["hv_m"]))


def draw(data: pd.DataFrame) -> Figure:
    """Two maps above two sets of lines."""
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=4.6)
    panels = list(figure.subplots(2, 2).flat)
    maps = style.rows(data, "plane")
    for axes, (name, title) in zip(panels[:2], MAPS.items(), strict=True):
        _draw_map(axes, maps, name)
        axes.set_title(title)
    lines = style.rows(data, "lines")
    for axes, (name, (title, label)) in zip(panels[2:], LINES.items(), strict=True):
        _draw_lines(axes, lines, name)
        axes.set_title(title)
        axes.set_ylabel(label)
    style.add_note(figure, data)
    return figure


def _draw_map(axes: Any, maps: pd.DataFrame, name: str) -> None:
    table = maps.pivot(index="hv_um", columns="h0_um", values=name)
    axes.set_xlabel(plane.H0_LABEL)
    axes.set_ylabel(plane.HV_LABEL)
    axes.set_xlim(table.columns.min(), table.columns.max())
    axes.set_ylim(table.index.min(), table.index.max())
    known = maps[maps[name].notna()]
    if known.empty:
        _nothing(axes)
        return
    if min(known["h0_um"].nunique(), known["hv_um"].nunique()) < 2:  # no lines between films
        axes.plot(known["h0_um"], known["hv_um"], "k.", markersize=3)
        for h0_um, hv_um, value in known[["h0_um", "hv_um", name]].to_numpy():
            axes.text(h0_um, hv_um, f"  {value:.3g}", fontsize=6, va="center")
        axes.set_xmargin(0.05)
        axes.set_ymargin(0.05)
        axes.autoscale()
        return
    lines = axes.contour(
        table.columns.to_numpy(),
        table.index.to_numpy(),
        np.ma.masked_invalid(table.to_numpy()),
        levels=7,
        colors="black",
        linewidths=0.9,
    )
    axes.clabel(lines, fontsize=6, fmt="%.4g")


def _nothing(axes: Any) -> None:
    """Neither lines nor numbers: an empty scale would look like a result."""
    axes.text(0.5, 0.5, "not known", transform=axes.transAxes, ha="center")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(False)


def _draw_lines(axes: Any, lines: pd.DataFrame, name: str) -> None:
    """One line for each of three gaps, named at its end."""
    gaps = sorted(lines["h0_um"].unique())
    if not gaps:
        _nothing(axes)
        return
    axes.set_xscale("log")
    axes.set_xlabel("frequency of modulation (Hz)")
    axes.grid(True)
    chosen = dict.fromkeys(gaps[index] for index in (0, len(gaps) // 2, -1))
    for gap, colour in zip(chosen, COLOURS, strict=False):
        line = lines[lines["h0_um"] == gap].sort_values("frequency_hz")
        axes.plot(line["frequency_hz"], line[name], color=colour, label=f"{gap:.3g} µm")
    if name == "gain":
        axes.legend(title="$h_0$", fontsize=6, title_fontsize=6)
