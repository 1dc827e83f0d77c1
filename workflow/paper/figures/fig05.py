"""Figure 5: amplitude of vibration over the actuator's surface, and where the finger may be."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from reporting.figures import style

COLUMNS = ("layer", "radius_mm", "angle_deg", "x_mm", "y_mm", "amplitude_ratio", "note")


def draw(data: pd.DataFrame) -> Figure:
    """The profile seen from above; layers surface, centre_limit (dashed) and finger."""
    figure = style.new_figure(height_in=3.5)
    axes = figure.subplots()
    surface = style.rows(data, "surface")
    x, y, amplitude = (
        surface.pivot(index="radius_mm", columns="angle_deg", values=name).to_numpy()
        for name in ("x_mm", "y_mm", "amplitude_ratio")
    )
    levels = np.linspace(-1, 1, 41)
    levels = levels[(levels >= amplitude.min() - 0.05) & (levels <= amplitude.max() + 0.01)]
    filled = axes.contourf(x, y, amplitude, levels=levels, cmap=style.SEQUENTIAL)
    if amplitude.min() < 0 < amplitude.max():
        node = axes.contour(x, y, amplitude, levels=[0], colors="white", linewidths=0.7)
        axes.clabel(node, fmt={0: "$h_a = 0$"}, fontsize=6, manual=[(0, float(y.max()))])
    limit, finger = style.rows(data, "centre_limit"), style.rows(data, "finger")
    axes.plot(
        limit["x_mm"],
        limit["y_mm"],
        color=style.VERMILLION,
        linestyle=(0, (4, 2)),
        linewidth=1.4,
        label="limit of the finger's centre",
    )
    axes.plot(finger["x_mm"], finger["y_mm"], color="black", label="finger, centred")
    axes.set_aspect("equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 5, 10]))
    reach = 1.04 * surface["radius_mm"].max()
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_xlabel("$x$ (mm)")
    axes.set_ylabel("$y$ (mm)")
    bar = figure.colorbar(filled, ax=axes, shrink=0.8, pad=0.02)
    bar.set_label("amplitude $h_a/h_v$ (–)")
    bar.set_ticks([tick for tick in np.arange(-0.2, 1.01, 0.2) if tick >= levels[0]])
    figure.legend(loc="outside upper center", ncols=2, handlelength=1.8, columnspacing=1.0)
    style.add_note(figure, data)
    return figure
