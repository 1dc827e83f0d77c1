"""The gap at which the film carries a load, and the film's stiffness there."""

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures import style
from reporting.figures.tables import in_micrometres, micrometres
from reporting.notes import percent, reynolds_limit
from reporting.results import Results

MOST_REYNOLDS = reynolds_limit("inertia neglected").not_above
COLOURS = (style.BLUE, style.GREEN, style.VERMILLION)


def levitation(results: Results) -> Figure:
    """Gap and stiffness over the load, for each amplitude; hollow beyond Re 10."""
    table = results.table("simulations/screen/levitation.csv", "load_n", "hv_m", "h0_m", "status")
    gaps_um = micrometres(results.scenes("screen")["h0_m"])
    data = in_micrometres(table).assign(stiffness_n_per_um=table["stiffness_n_per_m"] / 1e6)
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=2.6)
    gap, stiffness = figure.subplots(1, 2)
    gap.axhspan(gaps_um.min(), gaps_um.max(), color="0.92", zorder=0)
    for amplitude, colour in zip(sorted(data["hv_um"].unique()), COLOURS, strict=False):
        rows = data[data["hv_um"] == amplitude].dropna(subset="h0_um").sort_values("load_n")
        within = rows["modified_reynolds"] <= MOST_REYNOLDS
        label = f"$h_v$ = {amplitude:.3g} µm"
        for axes, name in ((gap, "h0_um"), (stiffness, "stiffness_n_per_um")):
            axes.plot(rows["load_n"], rows[name], color=colour, label=label)
            for fill, some in ((colour, rows[within]), ("white", rows[~within])):
                axes.plot(some["load_n"], some[name], "o", color=colour, markerfacecolor=fill, ms=4)
        gap.axhline(amplitude, color=colour, linestyle=":", linewidth=0.8)
    gap.set(title="(a) gap", ylabel="gap $h_0$ (µm)")
    stiffness.set(title="(b) stiffness", ylabel="stiffness (N/µm)")
    for axes in (gap, stiffness):
        axes.set(xscale="log", yscale="log", xlabel="load (N)")
        style.plain_numbers(axes.xaxis)
        style.plain_numbers(axes.yaxis)
        axes.grid(True)
    stiffness.legend(fontsize=6)
    style.add_note(figure, _note(table), results.beyond)
    return figure


def _note(table: pd.DataFrame) -> str:
    known = table[table["h0_m"].notna()]
    note = f"A gap is given for {len(known)} of {len(table)} loads"
    ends = known[["h0_modelling_error_lower_m", "h0_modelling_error_upper_m"]].abs().max(axis=1)
    if (shares := (ends / known["h0_m"]).dropna()).size:
        note += f"; modelling error up to {percent(float(shares.max()))} of a gap"
    return f"{note}."
