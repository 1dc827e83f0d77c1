"""Error map: relative error over the whole space.

Relative error of the fit on the optimal design over a dense grid of control simulations; dots mark
the design. A thick line would bound the region outside the band of allowed errors. The amplitude
axis is logarithmic, for the error changes fastest at small amplitudes.
"""

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import plane, style
from reporting.figures.parts.errors import error_note, error_table
from reporting.figures.parts.tables import Inputs, plane_table
from reporting.pages.notes import simulations_note
from squeezefilm.config.loading import Config
from squeezefilm.io.tables import read_ok_forces
from squeezefilm.models.fitted import read_fit

INPUTS = {
    "fit": "fits/two_factor_design.json",
    "forces": "simulations/error_map/forces.csv",
    "errors": "validation/two_factor_design_on_error_map.csv",
    "validation": "validation/two_factor_design_on_error_map.json",
    "design_forces": "simulations/two_factor_design/forces.csv",
    "device": "simulations/device.json",
}


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
    filled, lines = plane.error_contours(
        axes,
        style.rows(data, "map"),
        bins=14,
        ticks=(1, 2, 3, 5),
        colors="0.25",
        linewidths=0.5,
    )
    axes.clabel(lines, fontsize=6, fmt=lambda level: f"{level:g}".replace("-", "−"))
    plane.dots(
        axes,
        style.rows(data, "design"),
        fill="black",
        markersize=6,
        markeredgecolor="white",
        markeredgewidth=0.7,
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
