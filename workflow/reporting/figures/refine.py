"""Models refined: what was estimated in each round beside the truth, and where models fail.

Simulate, fit, judge on points that are never fitted, design, and so on until the estimated errors
are as small as wanted, or the model is found to be the limit. Left: estimates with their 95 %
limits, dashed what is wanted, stars the truth on simulations that no refinement used. Right: where
the best fit errs. Simulations have no scatter; the limits are about where in the space one looks.
"""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.colors import SymLogNorm
from matplotlib.figure import Figure

from reporting.figures.parts import plane, style

INPUTS = {
    "table": "refine/{space}_figure.csv",
}
LINEAR = 0.02
"""Share of the largest error, at least, up to which a map's colours are linear."""


def draw(data: pd.DataFrame) -> Figure:
    """A row for each model: errors against simulations, then maps of gap and of position.

    No map of the position where the finger stays at the centre, and no row for a model left out.
    """
    refined = data[data["layer"] != "left out"]
    models = list(dict.fromkeys(refined["model"]))
    if not models:
        return _nothing(data)
    moved = bool(data["x_mm"].abs().max() > 0)
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=0.5 + 2.1 * len(models))
    panels = figure.subplots(len(models), 3 if moved else 2, squeeze=False)
    for row, model in zip(panels, models, strict=True):
        rows = data[data["model"] == model]
        _draw_rounds(row[0], rows)
        row[0].set_title(f"{model}: {rows['verdict'].iloc[0]}")
        dots = _draw_map(row[1], rows, "h0_um", "hv_um")
        row[1].set_xlabel(plane.H0_LABEL)
        row[1].set_ylabel(plane.HV_LABEL)
        if moved:
            _draw_map(row[2], rows, "x_mm", "y_mm")
            row[2].set_xlabel("finger x (mm)")
            row[2].set_ylabel("finger y (mm)")
        bar = figure.colorbar(dots, ax=row[-1], pad=0.02)
        bar.set_label("error (%)")
        bar.ax.tick_params(labelsize=6)
    panels[0][0].legend(loc="best")
    style.add_note(figure, data)
    return figure


def _nothing(data: pd.DataFrame) -> Figure:
    """In words, that there is nothing to draw."""
    figure = style.new_figure(height_in=0.8)
    names = ", ".join(data["model"])
    figure.text(0.5, 0.5, f"Left out, so that nothing was simulated: {names}", ha="center")
    style.add_note(figure, data)
    return figure


def _draw_rounds(axes: Any, rows: pd.DataFrame) -> None:
    """Estimates with their limits, the wanted errors dashed, the truth as stars."""
    estimates, truth = style.rows(rows, "estimate"), style.rows(rows, "truth")
    wanted = style.rows(rows, "wanted").iloc[0]
    for name, colour, label in (
        ("worst_error_percent", style.VERMILLION, "worst"),
        ("global_error_percent", style.BLUE, "global"),
    ):
        known = estimates[np.isfinite(estimates[name])]
        axes.plot(known["simulations"], known[name], "o-", color=colour, markersize=3, label=label)
        axes.axhline(wanted[name], color=colour, linestyle="--", linewidth=0.6)
        axes.plot(truth["simulations"], truth[name], "*", color=colour, markersize=8, mec="black")
    centre = estimates["global_error_percent"]
    axes.errorbar(
        estimates["simulations"],
        centre,
        yerr=[
            centre - estimates["global_lower_percent"],
            estimates["global_upper_percent"] - centre,
        ],
        fmt="none",
        color=style.BLUE,
        linewidth=0.8,
        capsize=2,
    )
    axes.set_yscale("log")
    low, high = estimates["simulations"].min(), estimates["simulations"].max()
    axes.set_xlim(low - 1, high + 1)
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set_xlabel("simulations (–)")
    axes.set_ylabel("error (%)")
    axes.grid(axis="y")


def _draw_map(axes: Any, rows: pd.DataFrame, x: str, y: str) -> Any:
    """The error at a fair sample of the space, the largest on top; simulated points circled."""
    sample, simulated = style.rows(rows, "map"), style.rows(rows, "simulated")
    error = sample["relative_error_percent"].to_numpy(dtype=float)
    order = np.argsort(np.abs(error))
    top = max(float(np.nanmax(np.abs(error))), 1e-12)
    dots = axes.scatter(
        sample[x].to_numpy()[order],
        sample[y].to_numpy()[order],
        c=error[order],
        # Linear up to a power of ten, so that the ticks keep apart.
        norm=SymLogNorm(linthresh=10 ** np.ceil(np.log10(LINEAR * top)), vmin=-top, vmax=top),
        cmap=style.DIVERGING,
        s=6,
        linewidths=0,
    )
    axes.plot(simulated[x], simulated[y], "o", mfc="none", mec="black", mew=0.6, markersize=4)
    axes.tick_params(labelsize=6)
    return dots
