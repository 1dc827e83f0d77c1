"""Error against run time: relative error of the force by processor time, of four films.

A line for each method, refined along its own path; to the lower left is better. Above the orange
line the error is larger than that of the empirical model fitted to this study's screen; below the
grey band none can be seen, for the reference is no better. The films are the paper's actuator's.
"""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import style

INPUTS = {
    "table": "numerics/work_precision.csv",
}
STYLES = {
    "solver": ("black", "o", "-"),
    "solver, in a batch": ("black", "o", ":"),
    "same algorithm, NumPy, no symmetry": (style.BLUE, "D", "-"),
    "Chebyshev, Radau, Anderson": (style.GREEN, "v", "-"),
    "finite elements, Anderson": (style.PURPLE, "<", "-"),
    "finite elements from rest": (style.VERMILLION, "p", "-"),
}
"""Colour, marker and line of each method."""


def draw(data: pd.DataFrame) -> Figure:
    """A panel for each film, a line for each method."""
    style.check_known(STYLES, data["method"], what="method")
    films = list(dict.fromkeys(data["film"]))
    columns = min(2, len(films))
    rows = -(-len(films) // columns)
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=1.0 + 2.3 * rows)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    lowest = 0.2 * float(data["reference_uncertainty"].min())
    for panel, film in zip(panels, films, strict=False):
        here = data[data["film"] == film]
        floor = float(here["reference_uncertainty"].iloc[0])
        panel.axhline(float(here["model_error"].iloc[0]), color=style.ORANGE, linewidth=1.5)
        panel.axhspan(lowest, floor, color="0.85", linewidth=0, zorder=0)
        for method, (colour, marker, line) in STYLES.items():
            path = here[(here["method"] == method) & (here["status"] == "ok")]
            panel.plot(
                path["cpu_seconds"],
                np.maximum(path["relative_error"], floor),
                color=colour,
                marker=marker,
                linestyle=line,
                markersize=4,
                markerfacecolor="white" if line == ":" else colour,
                label=method,
            )
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_ylim(lowest, 1)
        panel.set_title(film)
        panel.grid(True)
        panel.set_xlabel("processor time per film (s)")
        panel.set_ylabel("relative error of the force (–)")
        panel.label_outer()
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    style.add_note(figure, data)
    return figure
