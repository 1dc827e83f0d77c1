"""Models compared: errors on the validation sample.

The paper's forms, polynomials, the study's own formulas and physics with nothing or little fitted,
each judged at simulations that no model was fitted to. In brackets the number of parameters, below
the name the global error; one scale of colour for all.
"""

from math import ceil

import numpy as np
import pandas as pd
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from reporting.figures.parts import plane, style

INPUTS = {
    "table": "models/{space}_errors.csv",
}
ACROSS = 4
DECADES = 5


def draw(data: pd.DataFrame) -> Figure:
    """A panel for each model in the h0–hv plane; larger errors are drawn over smaller ones."""
    if not data["relative_error_percent"].notna().any():
        figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=1.0)
        figure.text(0.5, 0.6, "no model can be judged on these points", ha="center")
        style.add_note(figure, data)
        return figure
    models = list(dict.fromkeys(data["model"]))
    across = min(ACROSS, len(models))
    down = ceil(len(models) / across)
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=0.5 + 1.85 * down)
    panels = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False).ravel()
    size = np.abs(data["relative_error_percent"].to_numpy(dtype=float))
    top = max(float(size.max()), 1e-10)
    lowest = top * 10.0**-DECADES
    scale = LogNorm(vmin=lowest, vmax=top)
    for axes in panels[len(models) :]:
        axes.set_visible(False)
    for axes, model in zip(panels, models, strict=False):
        rows = data[data["model"] == model]
        error = np.abs(rows["relative_error_percent"].to_numpy(dtype=float))
        order = np.argsort(error)
        dots = axes.scatter(
            rows["h0_um"].to_numpy()[order],
            rows["hv_um"].to_numpy()[order],
            c=np.maximum(error[order], lowest),
            norm=scale,
            cmap=style.SEQUENTIAL,
            s=5,
            linewidths=0,
        )
        first = rows.iloc[0]
        axes.set_title(
            f"{model} ({first['parameters']:.0f})\n{first['validation_error_percent']:.3g} %",
            fontsize=7,
        )
    for number, axes in enumerate(panels[: len(models)]):
        axes.tick_params(labelsize=6)
        if number % across == 0:
            axes.set_ylabel(plane.HV_LABEL)
        if number >= len(models) - across:
            axes.tick_params(labelbottom=True)
            axes.set_xlabel(plane.H0_LABEL)
    bar = figure.colorbar(dots, ax=list(panels), pad=0.02, extend="min")
    bar.set_label("|relative error| (%)")
    style.add_note(figure, data)
    return figure
