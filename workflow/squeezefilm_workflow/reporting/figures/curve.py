"""A curve of forces, as ``squeezefilm simulate`` writes it for several points."""

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from squeezefilm.errors import InputError
from squeezefilm.film.validity import OK
from squeezefilm_workflow.reporting.figures import style

AXES = {
    "h0_m": ("mean gap $h_0$", "µm", 1e6),
    "hv_m": ("amplitude $h_v$", "µm", 1e6),
    "x_m": ("position $x$", "mm", 1e3),
    "y_m": ("position $y$", "mm", 1e3),
    "phi_r_m": (r"radial position $\phi_r$", "mm", 1e3),
    "phi_deg": (r"angular position $\phi_\varphi$", "°", 1.0),
}
"""Factors in words, the unit in which they are drawn, and how many of it make one of a column's."""
COLUMNS = ("h0_m", "hv_m", "force_n", "force_error_n", "validity")
ERRORS = ("force_error_n", "measurement_noise_n", "misfit_n", "quadrature_n")
"""Of which a bar is the sum: the numerical error, and those of a scan."""
MOST_LINES = 12


def curve(table: pd.DataFrame) -> Figure:
    """Return forces over the factor with most values, a line for each combination of the others.

    Args:
        table: columns COLUMNS, and those of a position, if any.

    Raises InputError for a single point, and for more than MOST_LINES.
    """
    counts = {name: table[name].nunique() for name in AXES if name in table}
    along = max(counts, key=counts.__getitem__)
    others = [name for name in counts if counts[name] > 1 and name != along]
    lines = list(table.groupby(others)) if others else [((), table)]
    if counts[along] < 2 or len(lines) > MOST_LINES:
        what = f"{len(lines)} lines over {counts[along]} points"
        raise InputError(f"{what}: a curve has 2 points or more, and at most {MOST_LINES} lines")
    figure, axes = style.subplots(height_in=3.0)
    label, unit, size = AXES[along]
    axes.set(xlabel=f"{label} ({unit})", ylabel="mean force $F$ (N)")
    axes.grid(True)
    colours = mpl.colormaps[style.SEQUENTIAL](np.linspace(0, 0.85, len(lines)))
    for colour, (_, rows) in zip(colours, lines, strict=True):
        named = [(*AXES[name], rows[name].iloc[0]) for name in others]
        text = ", ".join(f"{word.split()[-1]} = {v * k:.4g} {u}" for word, u, k, v in named)
        error_n = rows[[name for name in ERRORS if name in rows]].sum(axis=1)
        data = rows.assign(at=rows[along] * size, error_n=error_n).sort_values("at")
        axes.errorbar("at", "force_n", "error_n", data=data, c=colour, fmt=".-", label=text)
        outside = data[data["validity"] != OK]
        axes.plot(outside["at"], outside["force_n"], ".", color="white", markersize=3, zorder=3)
    if others:
        axes.legend()
    style.add_note(
        figure, "Bars: numerical error and scan. Hollow: outside the limits of validity."
    )
    return figure
