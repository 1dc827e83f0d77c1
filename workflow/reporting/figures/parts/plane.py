"""The planes in which plans and designs are shown: gap and amplitude, and the finger's position."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, StrMethodFormatter

from reporting.figures.parts import style

H0_LABEL = r"mean gap $h_0$ (µm)"
HV_LABEL = r"amplitude $h_v$ (µm)"
LIMIT_COLUMNS = ("h0_min_um", "h0_max_um", "hv_min_um", "hv_max_um")


def set_up(axes: Axes, data: pd.DataFrame, *, headroom: float = 0.15) -> None:
    """Label the axes and leave room around the experimental space, whose limits the table tells.

    headroom is the room above the space, as a share of its height.
    """
    low_h0, high_h0, low_hv, high_hv = (float(data[name].iloc[0]) for name in LIMIT_COLUMNS)
    width, height = high_h0 - low_h0, high_hv - low_hv
    axes.set_xlabel(H0_LABEL)
    axes.set_ylabel(HV_LABEL)
    axes.set_xlim(low_h0 - 0.1 * width, high_h0 + 0.1 * width)
    axes.set_ylim(low_hv - 0.13 * height, high_hv + headroom * height)
    axes.grid(True)


def set_up_positions(axes: Axes, angles_deg: pd.Series, *, margin: float) -> None:
    """Label the axes of polar positions and leave a margin, a share of the range, at the angles."""
    low, high = min(0.0, float(angles_deg.min())), float(angles_deg.max())
    room = margin * ((high - low) or 45)
    axes.set_xlim(low - room, high + room)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 1.5, 3, 4.5, 6, 9, 10]))
    axes.set_xlabel(r"angular position $\phi_\varphi$ (°)")
    axes.set_ylabel(r"radial position $\phi_r$ (mm)")
    axes.grid(True)


def dots(
    axes: Axes, data: pd.DataFrame, *, x: str = "h0_um", y: str = "hv_um", fill: str, **look: Any
) -> None:
    """A dot for each row, also on the rim of the axes; ``look`` as matplotlib has it."""
    usual: dict[str, Any] = {"markeredgecolor": "black", "clip_on": False}
    axes.plot(data[x], data[y], "o", color=fill, **usual | look)


def error_contours(
    axes: Axes, data: pd.DataFrame, *, bins: int, ticks: Sequence[float], **lines: Any
) -> tuple[ContourSet, ContourSet]:
    """Relative errors on a grid as filled contours, and the lines between them.

    The amplitude's axis is logarithmic: the error changes fastest at small amplitudes.
    """
    table = data.pivot(index="hv_um", columns="h0_um", values="relative_error_percent")
    grid = table.columns.to_numpy(), table.index.to_numpy(), table.to_numpy()
    reach = float(np.abs(grid[2]).max())
    levels = MaxNLocator(nbins=bins, symmetric=True).tick_values(-reach, reach)
    axes.set_xlim(grid[0][0], grid[0][-1])
    axes.set_ylim(grid[1][0], grid[1][-1])
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=ticks))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    filled = axes.contourf(*grid, levels=levels, cmap=style.DIVERGING)
    drawn = axes.contour(*grid, levels=levels, **lines)
    band = float(data["band_percent"].iloc[0])
    if reach > band:
        error = np.abs(grid[2])
        axes.contour(*grid[:2], error, levels=[band], colors="black", linewidths=1.8)
    return filled, drawn


def label_points(axes: Axes, data: pd.DataFrame, *, labels: Iterable[str]) -> None:
    """Write a label beside each point, towards the middle of the axes, or above one at the top."""
    middle_h0 = sum(axes.get_xlim()) / 2
    low_hv, high_hv = axes.get_ylim()
    for h0_um, hv_um, label in zip(data["h0_um"], data["hv_um"], labels, strict=True):
        left, height = h0_um < middle_h0, (hv_um - low_hv) / (high_hv - low_hv)
        below = 0.4 < height < 0.7
        axes.annotate(
            label,
            (h0_um, hv_um),
            xytext=(5 if left else -5, -4 if below else 4),
            textcoords="offset points",
            ha="left" if left else "right",
            va="top" if below else "bottom",
            fontsize=7,
            path_effects=[withStroke(linewidth=2, foreground="white")],
            zorder=4,
        )
