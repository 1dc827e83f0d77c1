"""The solver examined: its error against run time."""

import numpy as np
from matplotlib.figure import Figure

from reporting.figures import style
from reporting.results import Results

STYLES = {
    "solver": ("black", "o", "-"),
    "solver, in a batch": ("black", "o", ":"),
    "same algorithm, NumPy, no symmetry": (style.BLUE, "D", "-"),
    "Chebyshev, Radau, Anderson": (style.GREEN, "v", "-"),
    "finite elements, Anderson": (style.PURPLE, "<", "-"),
    "finite elements from rest": (style.VERMILLION, "p", "-"),
}
"""Colour, marker and line of each method."""


def work_precision(results: Results) -> Figure:
    """A panel for each film, a line for each method."""
    data = results.table("numerics/work_precision.csv", "film", "method", "relative_error")

    films = data["film"].unique()
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
        panel.set(title=film, xscale="log", yscale="log", ylim=(lowest, 1))
        panel.set(xlabel="processor time per film (s)", ylabel="relative error of the force (–)")
        panel.grid(True)
        panel.label_outer()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    note = "Orange: error of the empirical model; grey: what the reference cannot tell apart."
    style.add_note(figure, note)
    return figure
