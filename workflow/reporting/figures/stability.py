"""Stiff and extreme films: every case with its verdict, and what each check found.

A row for each film, a column for each check that the solver does not know of, and the verdict:
solved, unchecked (solved, but no check can be had), refused for a documented reason, or failed.
Single precision is no check but a warning: what the same algorithm would lose in float32. The films
are the same for every study.
"""

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from reporting.figures.parts import style

INPUTS = {
    "table": "numerics/stability.csv",
}
CHECKS = {
    "method_difference": "chosen\nmethod",
    "limit_difference": "from its\nlimit",
    "defect": "defect,\nforce",
    "state_defect": "defect,\npressure",
    "mass_balance": "mass\nbalance",
    "piston_identity": r"$\langle H^3P^2\rangle$",
    "scrambled_difference": "sums\nreordered",
    "finer_difference": "finer\ngrid",
    "single_precision_difference": "single\nprecision",
}
VERDICTS = {
    "solved": ("o", style.GREEN, "full"),
    "unchecked": ("o", style.GREEN, "none"),
    "refused": ("s", style.GREY, "full"),
    "failed": ("X", style.VERMILLION, "full"),
}
SMALLEST, LARGEST = 1e-16, 1.0
ROW_IN = 0.135


def draw(data: pd.DataFrame) -> Figure:
    """A row per case, a column per check, coloured by the size of the difference found."""
    style.check_known(VERDICTS, data["verdict"], what="verdict")
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=1.35 + ROW_IN * len(data))
    axes = figure.subplots()
    values = data.reindex(columns=list(CHECKS)).to_numpy(dtype=float)
    shown = np.clip(values, SMALLEST, LARGEST)
    colours = mpl.colormaps["cividis"].with_extremes(bad="white")
    image = axes.imshow(
        np.ma.masked_invalid(shown),
        aspect="auto",
        norm=LogNorm(SMALLEST, LARGEST),
        cmap=colours,
        interpolation="nearest",
    )
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value) or value == np.inf:
            axes.text(
                column,
                row,
                "lost" if value >= 0.3 else _short(value),
                ha="center",
                va="center",
                fontsize=5.2,
                color="black" if value > 1e-7 else "white",
            )
    extra = len(CHECKS)
    for row, (pressure, iterations) in enumerate(
        zip(data["lowest_pressure"], data["krylov_iterations"], strict=True)
    ):
        for column, text in (
            (extra, f"{pressure:.2f}" if np.isfinite(pressure) else ""),
            (extra + 1, f"{iterations:.0f}" if np.isfinite(iterations) else ""),
        ):
            axes.text(column, row, text, ha="center", va="center", fontsize=5.2)
    for verdict, (marker, colour, fill) in VERDICTS.items():
        rows = np.flatnonzero(data["verdict"] == verdict)
        axes.plot(
            np.full(len(rows), extra + 2),
            rows,
            marker,
            color=colour,
            fillstyle=fill,
            markersize=4,
            label=f"{verdict} ({len(rows)})",
        )
    axes.set_xlim(-0.5, extra + 2.5)
    axes.set_ylim(len(data) - 0.5, -0.5)
    axes.set_xticks(
        range(extra + 3),
        [*CHECKS.values(), "lowest\npressure", "Krylov\niterations", "verdict"],
        fontsize=6,
    )
    axes.xaxis.tick_top()
    axes.set_yticks(range(len(data)), data["case"].tolist(), fontsize=5.6)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    bar = figure.colorbar(image, ax=axes, pad=0.01, fraction=0.025, aspect=40)
    bar.set_label("relative difference found by the check")
    figure.legend(loc="outside upper right", ncols=len(VERDICTS))
    style.add_note(figure, data)
    return figure


def _short(value: float) -> str:
    """One digit and an exponent: 2e-6."""
    if value == 0:
        return "0"
    mantissa, _, exponent = f"{value:.0e}".partition("e")
    return f"{mantissa}e{int(exponent)}"
