"""Error map: relative error of the five-point fit over a dense grid of control simulations."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, StrMethodFormatter

from reporting.figures import plane, style

COLUMNS = ("layer", "h0_um", "hv_um", "relative_error_percent", "band_percent", "note")


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
