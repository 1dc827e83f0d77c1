"""A surface in space, drawn as a mesh, with points on it."""

from collections.abc import Mapping
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from reporting.figures.parts import plane, style


def add_axes(
    figure: Figure, *, labels: tuple[str, str, str], azimuth_deg: float, bottom: float
) -> Axes3D:
    """Axes in space that fill the figure above ``bottom``, a share of its height.

    Axes in space do not take part in the usual layout.
    """
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.025, bottom, 0.935, 1 - bottom), projection="3d")
    assert isinstance(axes, Axes3D)
    axes.set_box_aspect((1.2, 1.2, 0.85), zoom=1.0)
    axes.view_init(elev=24, azim=azimuth_deg)
    axes.computed_zorder = False  # so that points can stand in front of the mesh
    axes.set_xlabel(labels[0], labelpad=-5)
    axes.set_ylabel(labels[1], labelpad=-5)
    axes.set_zlabel(labels[2], labelpad=-5)
    axes.tick_params(pad=-2)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1, 1, 1, 0))
        axis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 5, 10]))
    return axes


def mesh(
    axes: Axes3D, x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64]
) -> None:
    """Draw a mesh of shape (m, n) coloured by its height z."""
    colours = mpl.colormaps[style.SEQUENTIAL](mpl.colors.Normalize()(z))
    colours[..., :3] = 0.45 * colours[..., :3] + 0.55  # light, so that points stand out
    axes.plot_surface(
        x,
        y,
        z,
        facecolors=colours,
        edgecolor="0.4",
        linewidth=0.25,
        rcount=z.shape[0],
        ccount=z.shape[1],
        shade=False,
        zorder=1,
    )


def add_force_axes(figure: Figure, *, bottom: float) -> Axes3D:
    """Axes of force over gap and amplitude, seen so that no part of the surface hides another."""
    return add_axes(
        figure,
        labels=(plane.H0_LABEL, plane.HV_LABEL, r"force $\eta$ (N)"),
        azimuth_deg=-132,
        bottom=bottom,
    )


def force_mesh(axes: Axes3D, data: pd.DataFrame) -> None:
    """Draw a grid of rows h0_um, hv_um, force_n as a mesh."""
    table = data.pivot(index="h0_um", columns="hv_um", values="force_n")
    h0, hv = np.meshgrid(table.index, table.columns, indexing="ij")
    mesh(axes, h0, hv, table.to_numpy())


def force_points(
    axes: Axes3D, data: pd.DataFrame, *, color: str, label: str, s: float = 11
) -> None:
    """Draw rows h0_um, hv_um, force_n as dots in front of the mesh."""
    axes.scatter(
        data["h0_um"],
        data["hv_um"],
        data["force_n"],
        s=s,
        color=color,
        edgecolor="black",
        linewidth=0.5,
        depthshade=False,
        label=label,
        zorder=5,
    )


def model_and_points(data: pd.DataFrame, points: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Layer model as a mesh, and layers of dots, each with its look (see force_points)."""
    figure = style.new_figure(height_in=3.1)
    axes = add_force_axes(figure, bottom=style.add_note(figure, data))
    force_mesh(axes, style.rows(data, "model"))
    for layer, look in points.items():
        force_points(axes, style.rows(data, layer), **look)
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.97), handletextpad=0.2)
    return figure
