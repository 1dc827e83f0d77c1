"""The planes in which plans and designs are shown: gap and amplitude, and the finger's position."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

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
