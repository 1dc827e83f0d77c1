"""Levitation: the gap at which the film carries a load, and the film's stiffness there.

For three amplitudes of the screen, the finger at the centre: where the mean force equals the load.
Dotted: the surface would touch. Grey: the gaps of the study; outside them models are extrapolated,
simulations are not. No gap is given where its modelling error is more than a tenth of it, or the
film equation's limits of validity are exceeded. Hollow: beyond Re 10.
"""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import style
from reporting.figures.parts.tables import Inputs, micrometres
from reporting.pages.notes import reynolds_limit
from squeezefilm.config.loading import Config
from squeezefilm.io.sources import read_columns

INPUTS = {
    "levitation": "simulations/screen/levitation.csv",
    "screen": "simulations/screen/scenes.csv",
}
MOST_REYNOLDS = reynolds_limit("inertia neglected").not_above
COLOURS = (style.BLUE, style.GREEN, style.VERMILLION)
COLUMNS = (
    "load_n",
    "hv_um",
    "h0_um",
    "stiffness_n_per_um",
    "modified_reynolds",
    "h0_min_um",
    "h0_max_um",
    "note",
)


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """A row for each load and amplitude; without a gap where none is given (`levitate`)."""
    table = read_columns(inputs["levitation"], columns=("load_n", "hv_m", "h0_m", "status"))
    gaps = micrometres(read_columns(inputs["screen"], columns=("h0_m",))["h0_m"])
    scan = "with the scan's noise in the gap, " * (
        config["actuator"]["profile"]["kind"] == "measured"
    )
    return table.assign(
        hv_um=micrometres(table["hv_m"]),
        h0_um=micrometres(table["h0_m"]),
        stiffness_n_per_um=table["stiffness_n_per_m"] / 1e6,
        h0_min_um=gaps.min(),
        h0_max_um=gaps.max(),
        note=_note(table, scan=scan),
    )[list(COLUMNS)]


def _note(table: pd.DataFrame, *, scan: str) -> str:
    known = table[table["h0_m"].notna()]
    if known.empty:
        return f"No gap is given for any of the {len(table)} loads."
    within = known[known["modified_reynolds"] <= MOST_REYNOLDS]
    numerical = max(
        (known["h0_error_m"] / known["h0_m"]).max(),
        (known["stiffness_error_n_per_m"] / known["stiffness_n_per_m"].abs()).max(),
    )
    note = (
        f"A gap is given for {len(known)} of {len(table)} loads. Numerical error {scan}up to "
        f"{100 * float(numerical):.1g} %"
    )
    ends = known[["h0_modelling_error_lower_m", "h0_modelling_error_upper_m"]].abs().max(axis=1)
    if (shares := (ends / known["h0_m"]).dropna()).size:
        note += f"; modelling error up to {100 * float(shares.max()):.2g} % of a gap"
    note += ". Dotted: h0 = hv, contact of an even gap; grey: the study's gaps"
    return note + (f"; hollow: beyond Re {MOST_REYNOLDS:g}." if len(within) < len(known) else ".")


def draw(data: pd.DataFrame) -> Figure:
    """Gap and stiffness over the load."""
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=2.6)
    gap, stiffness = figure.subplots(1, 2)
    gap.axhspan(data["h0_min_um"].iloc[0], data["h0_max_um"].iloc[0], color="0.92", zorder=0)
    amplitudes = sorted(data["hv_um"].unique())
    for amplitude, colour in zip(amplitudes, COLOURS, strict=False):
        rows = data[data["hv_um"] == amplitude].dropna(subset="h0_um").sort_values("load_n")
        label = f"$h_v$ = {amplitude:.3g} µm"
        for axes, name in ((gap, "h0_um"), (stiffness, "stiffness_n_per_um")):
            axes.plot(rows["load_n"], rows[name], color=colour, label=label)
            for fill, some in (
                (colour, rows[rows["modified_reynolds"] <= MOST_REYNOLDS]),
                ("white", rows[rows["modified_reynolds"] > MOST_REYNOLDS]),
            ):
                axes.plot(some["load_n"], some[name], "o", color=colour, markerfacecolor=fill, ms=4)
        gap.axhline(amplitude, color=colour, linestyle=":", linewidth=0.8)
    for axes, title, label in (
        (gap, "(a) gap", "gap $h_0$ (µm)"),
        (stiffness, "(b) stiffness", "stiffness (N/µm)"),
    ):
        axes.set_xscale("log")
        axes.set_yscale("log")
        style.plain_numbers(axes.xaxis)
        style.plain_numbers(axes.yaxis)
        axes.set_xlabel("load (N)")
        axes.set_ylabel(label)
        axes.set_title(title)
        axes.grid(True)
    stiffness.legend(fontsize=6)
    style.add_note(figure, data)
    return figure
