"""Force map: the force over gap and amplitude, and the amplitude for the wanted force.

(a) The mean force with the finger at the centre, from the control simulations (dots); thick, where
it is the wanted one. (b) At each position of the finger the amplitude that gives the wanted force
at the study's gap, by the recommended model, in micrometres; hollow where the model is not
validated, a cross where no amplitude gives that force.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator

from reporting.figures.parts import plane, style
from reporting.figures.parts.tables import Inputs, micrometres, plane_table
from reporting.pages.notes import percent
from squeezefilm.config.loading import Config
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import read_ok_forces
from squeezefilm.models.experiments import factors_of

INPUTS = {
    "forces": "simulations/error_map/forces.csv",
    "recommended": "models/recommended.csv",
}
ALONE_MM = 5.0
"""What is shown either way of a single position."""
DECADE = 10.0
"""Forces that span more than this are drawn on a logarithmic scale."""


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers map (simulated forces) and wanted (amplitudes at positions, or NaN)."""
    forces = read_ok_forces(inputs["forces"])
    table = read_columns(inputs["recommended"], columns=("space", "model", "h0_m", "force_n"))
    table = table[table["model"].notna()]
    wanted_n = config["extrapolation"]["force_n"]
    note = f"Wanted: {wanted_n:g} N. (b): no model compared can be judged."
    wanted = pd.DataFrame()
    if len(table):
        anywhere = table[table["space"] == table["space"].iloc[-1]]
        at = factors_of(anywhere.assign(hv_m=0.0))
        first = anywhere.iloc[0]
        wanted = pd.DataFrame(
            {
                "layer": "wanted",
                "x_mm": 1e3 * at.x_m,
                "y_mm": 1e3 * at.y_m,
                "hv_um": micrometres(anywhere["hv_m"]),
                "validated": anywhere["error_95_percent"].notna().to_numpy(),
            }
        )
        note = (
            f"Wanted: {wanted_n:g} N. (b): h0 = {1e6 * first['h0_m']:g} µm, by the model "
            f"{first['model']}, {percent(float(first['validation_error']))} off over "
            f"{first['validation_points']:.0f} points of the validation sample, at most "
            f"{percent(float(first['worst_error']))} at any of {first['simulations']:.0f} "
            "simulations; hollow: not validated."
        )
    map_ = plane_table(forces, layer="map")
    return pd.concat([map_, wanted], ignore_index=True).assign(wanted_n=wanted_n, note=note)


def draw(data: pd.DataFrame) -> Figure:
    """The map of forces and the amplitudes at the positions."""
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=3.2)
    figure.set_layout_engine("constrained", w_pad=0.08)  # markers stand over the rim
    left, right = figure.subplots(1, 2)
    _draw_map(figure, left, style.rows(data, "map"), wanted_n=float(data["wanted_n"].iloc[0]))
    rows = style.rows(data, "wanted")
    if len(rows):
        _draw_positions(figure, right, rows)
    else:
        right.set_visible(False)
    style.add_note(figure, data)
    return figure


def _draw_map(figure: Figure, axes: Axes, rows: pd.DataFrame, *, wanted_n: float) -> None:
    table = rows.pivot(index="hv_um", columns="h0_um", values="force_n")
    grid = table.columns.to_numpy(), table.index.to_numpy(), table.to_numpy()
    low, high = float(np.nanmin(grid[2])), float(np.nanmax(grid[2]))
    wide = low > 0 and high > DECADE * low
    ticks = LogLocator(subs=(1, 2, 5)) if wide else MaxNLocator(nbins=12)
    levels = np.asarray(ticks.tick_values(low, high))
    levels = levels[(levels > low / 3) & (levels < 3 * high)]
    drawn = axes.contourf(
        *grid, levels=levels, cmap=style.SEQUENTIAL, norm="log" if wide else None, extend="both"
    )
    axes.contour(*grid, levels=levels, colors="0.3", linewidths=0.3)
    if low < wanted_n < high:
        axes.contour(*grid, levels=[wanted_n], colors="black", linewidths=2.0)
    plane.dots(axes, rows, fill="white", markersize=2.6, markeredgecolor="0.4")
    axes.set_xlabel(plane.H0_LABEL)
    axes.set_ylabel(plane.HV_LABEL)
    axes.set_title("(a) force at the centre")
    bar = figure.colorbar(drawn, ax=axes, format="%g")
    bar.ax.minorticks_off()
    bar.set_label("mean force (N)")


def _draw_positions(figure: Figure, axes: Axes, rows: pd.DataFrame) -> None:
    known = rows[rows["hv_um"].notna()]
    none = rows[rows["hv_um"].isna()]
    validated = known["validated"].astype(bool).to_numpy()
    axes.plot(known["x_mm"][validated], known["y_mm"][validated], "o", color=style.BLUE, ms=5)
    axes.plot(
        known["x_mm"][~validated],
        known["y_mm"][~validated],
        "o",
        color=style.BLUE,
        ms=5,
        mfc="white",
    )
    axes.plot(none["x_mm"], none["y_mm"], "x", color=style.VERMILLION)
    for row in known.itertuples():
        axes.annotate(
            f"{row.hv_um:.2f}",
            (row.x_mm, row.y_mm),
            xytext=(0, 5),
            textcoords="offset points",
            ha="center",
            fontsize=6,
        ).set_in_layout(False)
    axes.margins(0.15)
    if len(known) + len(none) == 1:  # nothing else says how large a millimetre is
        axes.set_xlim(-ALONE_MM, ALONE_MM)
        axes.set_ylim(-ALONE_MM, ALONE_MM)
    axes.set_xlabel("finger's centre, $x$ (mm)")
    axes.set_ylabel("$y$ (mm)")
    axes.set_title("(b) amplitude wanted (µm)")
    axes.grid(True)
