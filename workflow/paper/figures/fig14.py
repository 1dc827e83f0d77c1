"""Figure 14: relative error of that model on the screen.

Relative error of the fit on the optimal design at the screen's points: model minus simulation over
simulation. Dots are white inside the band and black outside.
"""

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import plane, style
from reporting.figures.parts.errors import error_note, error_table
from reporting.figures.parts.tables import Inputs
from reporting.pages.notes import simulations_note
from squeezefilm.config.loading import Config
from squeezefilm.io.tables import read_ok_forces
from squeezefilm.models.fitted import read_fit

INPUTS = {
    "fit": "fits/two_factor_design.json",
    "forces": "simulations/screen/forces.csv",
    "errors": "validation/two_factor_design_on_screen.csv",
    "validation": "validation/two_factor_design_on_screen.json",
    "device": "simulations/device.json",
}


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """One row per control point."""
    fit, forces = read_fit(inputs["fit"]), read_ok_forces(inputs["forces"])
    note = (
        f"{error_note(inputs['validation'], fit=f'Fit on {fit.points} points')} "
        f"{simulations_note(inputs['device'], forces)}"
    )
    data = error_table(inputs["errors"], inputs["validation"], layer="control")
    return data.assign(note=note)


def draw(data: pd.DataFrame) -> Figure:
    """Error over amplitude, a line per gap; dots white inside the band and black outside."""
    figure = style.new_figure(height_in=2.9)
    axes = figure.subplots()
    band = float(data["band_percent"].iloc[0])
    axes.axhspan(-band, band, color="0.94", zorder=0)
    for edge in (-band, band):
        axes.axhline(edge, color="0.45", linestyle=(0, (4, 2)), linewidth=0.8)
    axes.axhline(0, color="0.6", linewidth=0.6)
    gaps = np.sort(data["h0_um"].unique())
    colours = mpl.colormaps["viridis"](np.linspace(0, 0.92, len(gaps)))
    for gap, colour in zip(gaps, colours, strict=True):
        line = data[data["h0_um"] == gap].sort_values("hv_um")
        axes.plot(
            line["hv_um"], line["relative_error_percent"], color=colour, label=f"{gap:g}", zorder=2
        )
    inside = data["in_band"].astype(bool)
    for chosen, colour in ((inside, "white"), (~inside, "black")):
        axes.plot(
            data["hv_um"][chosen],
            data["relative_error_percent"][chosen],
            "o",
            color=colour,
            markersize=3.6,
            markeredgecolor="black",
            markeredgewidth=0.6,
            zorder=3,
        )
    reach = max(1.25 * band, 1.1 * data["relative_error_percent"].abs().max())
    axes.set_ylim(-reach, reach)
    axes.set_xlabel(plane.HV_LABEL)
    axes.set_ylabel("relative error (%)")
    axes.text(
        0.99,
        band,
        f"±{band:g} % band ",
        transform=axes.get_yaxis_transform(),
        ha="right",
        va="bottom",
        fontsize=7,
    )
    figure.legend(
        loc="outside upper center",
        title=r"mean gap $h_0$ (µm)",
        title_fontsize=7,
        ncols=6,
        handlelength=1.2,
        columnspacing=0.8,
        handletextpad=0.4,
    )
    style.add_note(figure, data)
    return figure
