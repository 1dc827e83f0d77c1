"""Error map: relative error over the whole space.

Relative error of the fit on the optimal design over a dense grid of control simulations; dots mark
the design. A thick line would bound the region outside the band of allowed errors. The amplitude
axis is logarithmic, for the error changes fastest at small amplitudes.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, StrMethodFormatter

from reporting.figures.parts import plane, style
from reporting.figures.parts.errors import error_note, error_table
from reporting.figures.parts.tables import Inputs, plane_table
from reporting.pages.notes import simulations_note
from squeezefilm.io.tables import read_ok_forces
from squeezefilm.models.fitted import read_fit
from squeezefilm.studies.config import Config

INPUTS = {
    "fit": "fits/two_factor_design.json",
    "forces": "simulations/error_map/forces.csv",
    "errors": "validation/two_factor_design_on_error_map.csv",
    "validation": "validation/two_factor_design_on_error_map.json",
    "design_forces": "simulations/two_factor_design/forces.csv",
    "device": "simulations/device.json",
}
COLUMNS = ("layer", "h0_um", "hv_um", "relative_error_percent", "band_percent", "note")


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers map (the grid of control points) and design."""
    fit, forces = read_fit(inputs["fit"]), read_ok_forces(inputs["forces"])
    design = read_ok_forces(inputs["design_forces"])
    grid = error_table(inputs["errors"], inputs["validation"], layer="map")
    data = pd.concat(
        [grid, plane_table(design, layer="design").drop(columns="force_n")], ignore_index=True
    )
    note = (
        f"{error_note(inputs['validation'], fit=f'Fit on {fit.points} points')} "
        f"{simulations_note(inputs['device'], forces, design)}"
    )
    return data.assign(band_percent=grid["band_percent"].iloc[0], note=note)


def draw(data: pd.DataFrame) -> Figure:
    """Layers map (a grid, drawn as filled contours) and design (black dots).

    The edge of the ±band is a thick line where the error reaches it.
    """
    figure = style.new_figure(width_in=style.SINGLE_COLUMN_IN, height_in=3.2)
    axes = figure.subplots()
    table = style.rows(data, "map").pivot(
        index="hv_um", columns="h0_um", values="relative_error_percent"
    )
    h0_um, hv_um, error = table.columns.to_numpy(), table.index.to_numpy(), table.to_numpy()
    band = float(data["band_percent"].iloc[0])
    reach = float(np.abs(error).max())
    levels = MaxNLocator(nbins=14, symmetric=True).tick_values(-reach, reach)
    axes.set_xlim(h0_um[0], h0_um[-1])
    axes.set_ylim(hv_um[0], hv_um[-1])
    axes.set_yscale("log")  # the error changes fastest at small amplitudes
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    filled = axes.contourf(h0_um, hv_um, error, levels=levels, cmap=style.DIVERGING)
    lines = axes.contour(h0_um, hv_um, error, levels=levels, colors="0.25", linewidths=0.5)
    axes.clabel(lines, fontsize=6, fmt=lambda level: f"{level:g}".replace("-", "−"))
    if reach > band:
        axes.contour(h0_um, hv_um, np.abs(error), levels=[band], colors="black", linewidths=1.8)
    design = style.rows(data, "design")
    axes.plot(
        design["h0_um"],
        design["hv_um"],
        "o",
        color="black",
        markeredgecolor="white",
        markeredgewidth=0.7,
        markersize=6,
        clip_on=False,
        zorder=4,
        label="design point",
    )
    axes.set_xlabel(plane.H0_LABEL)
    axes.set_ylabel(plane.HV_LABEL)
    bar = figure.colorbar(filled, ax=axes, pad=0.02)
    bar.set_label("relative error (%)")
    figure.legend(loc="outside upper center", handletextpad=0.2)
    style.add_note(figure, data)
    return figure
