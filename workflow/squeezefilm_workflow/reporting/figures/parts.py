"""Parts of several figures: planes of gap and amplitude, forces in space, tables."""

from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation
from matplotlib.ticker import MaxNLocator, NullLocator
from mpl_toolkits.mplot3d import Axes3D

from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import FittedModel
from squeezefilm_workflow.reporting.figures import style
from squeezefilm_workflow.reporting.notes import percent_text, signed_text
from squeezefilm_workflow.reporting.results import Results

GAP_AMPLITUDE_LABELS = {"xlabel": r"mean gap $h_0$ (µm)", "ylabel": r"amplitude $h_v$ (µm)"}
"""Labels of a plane: gap to the right, amplitude upwards."""
CONTOUR_LABEL_MARGINS = (0.035, 0.02)
"""Between the labels of contours and the rim of the axes, fractions of the axes."""
MESH_LINES_PER_FACTOR = 26
"""Lines of a model's mesh along each factor."""


def gap_amplitude_table(table: pd.DataFrame, *, layer: str) -> pd.DataFrame:
    """Gap and amplitude of a table of scenes in µm, with the force in N where it is known."""
    columns = ["layer", "h0_um", "hv_um", *(["force_n"] if "force_n" in table else [])]
    return with_micrometre_columns(table).assign(layer=layer)[columns].reset_index(drop=True)


def with_micrometre_columns(table: pd.DataFrame) -> pd.DataFrame:
    """The table with gap and amplitude in µm, too."""
    return table.assign(
        h0_um=metres_to_micrometres(table["h0_m"]), hv_um=metres_to_micrometres(table["hv_m"])
    )


def metres_to_micrometres(metres: pd.Series) -> np.ndarray:
    """Metres in µm, rounded so that 7e-6 becomes 7 and not 7.000000000000001."""
    return np.round(metres.to_numpy(dtype=float) * 1e6, 9)


def model_mesh_table(fit: FittedModel, screen: pd.DataFrame) -> pd.DataFrame:
    """The fitted force of a centred pad on a mesh over the experimental space."""
    ends = ((screen[name].min(), screen[name].max()) for name in ("h0_m", "hv_m"))
    lines = (np.linspace(*each, MESH_LINES_PER_FACTOR) for each in ends)
    h0_m, hv_m = (values.ravel() for values in np.meshgrid(*lines, indexing="ij"))
    force_n = fit.force_model.evaluate(fit.theta, Factors.of(h0_m=h0_m, hv_m=hv_m))
    mesh = pd.DataFrame({"h0_m": h0_m, "hv_m": hv_m, "force_n": force_n})
    return gap_amplitude_table(mesh, layer="model")


def error_table(results: Results, fit: str, plan: str, *, layer: str) -> pd.DataFrame:
    """Relative error of a fit in percent at each point of a plan, and whether it is in the band."""
    points, band = results.errors(fit, plan), results.validation_errors(fit, plan)["band"]
    return gap_amplitude_table(points[["h0_m", "hv_m"]], layer=layer).assign(
        relative_error_percent=100 * points["relative_error"],
        in_band=points["relative_error"].abs() <= band,
        band_percent=100 * band,
    )


def fit_error_note(results: Results, fit: str, plan: str) -> str:
    """The errors of a fit over the points of a plan."""
    errors = results.validation_errors(fit, plan)
    return (
        f"{errors['points']:.0f} points: global error {percent_text(errors['global_error'])}, "
        f"largest {percent_text(errors['worst_relative_error'])}"
    )


def interpolation_note(points: pd.DataFrame) -> str:
    """Return a note on where the values of a map are computed."""
    return f"Interpolated linearly between {len(points)} simulated points (h0, hv)."


def set_up_gap_amplitude_axes(axes: Axes, screen: pd.DataFrame, *, headroom: float = 0.15) -> None:
    """Label the axes and leave room around the experimental space, that of the screen's scenes.

    headroom is the room above the space, as a share of its height.
    """
    axes.set(**GAP_AMPLITUDE_LABELS)
    for set_limits, name, below, above in (
        (axes.set_xlim, "h0_m", 0.1, 0.1),
        (axes.set_ylim, "hv_m", 0.13, headroom),
    ):
        low, high = 1e6 * float(screen[name].min()), 1e6 * float(screen[name].max())
        set_limits(low - below * (high - low), high + above * (high - low))
    axes.grid(True)


def set_up_position_axes(axes: Axes, angles_deg: pd.Series, *, margin: float) -> None:
    """Label the axes of polar positions and leave a margin, a share of the range, at the angles."""
    low, high = min(0.0, float(angles_deg.min())), float(angles_deg.max())
    room = margin * ((high - low) or 45)
    axes.set_xlim(low - room, high + room)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 1.5, 3, 4.5, 6, 9, 10]))
    axes.set(xlabel=r"angular position $\phi_\varphi$ (°)", ylabel=r"radial position $\phi_r$ (mm)")
    axes.grid(True)


def draw_dots(
    axes: Axes, data: pd.DataFrame, *, x: str = "h0_um", y: str = "hv_um", fill: str, **look: Any
) -> None:
    """A dot for each row, also on the rim of the axes; ``look`` as matplotlib has it."""
    usual: dict[str, Any] = {"markeredgecolor": "black", "clip_on": False}
    axes.plot(data[x], data[y], "o", color=fill, **usual | look)


def draw_coloured_dots(
    axes: Axes, data: pd.DataFrame, value: str, *, x: str = "h0_um", y: str = "hv_um", **look: Any
) -> PathCollection:
    """A dot for each row, coloured by a value; ``look`` as matplotlib has it."""
    return axes.scatter(data[x], data[y], c=data[value], **{"linewidths": 0} | look)


def grid_arrays_of_table(
    data: pd.DataFrame, value: str, *, x: str = "h0_um", y: str = "hv_um"
) -> Any:
    """x, y and the values over them (rows along y) of a table that is a grid."""
    table = data.pivot(index=y, columns=x, values=value)
    return table.columns.to_numpy(), table.index.to_numpy(), table.to_numpy()


def limit_axes_to_grid(axes: Axes, grid: Any) -> None:
    """Limit the axes to a grid (see grid_of)."""
    axes.set(xlim=grid[0][[0, -1]], ylim=grid[1][[0, -1]])


def annotate_at(
    axes: Axes, text: str, point: tuple[Any, Any], offset_pt: tuple[float, float], **look: Any
) -> Annotation:
    """Write a text at a distance from a place; ``look`` as matplotlib has it."""
    return axes.annotate(text, point, xytext=offset_pt, textcoords="offset points", **look)


def write_not_known(axes: Axes) -> None:
    """Say so in the middle of the axes: an empty scale would look like a result."""
    axes.text(0.5, 0.5, "not available", transform=axes.transAxes, ha="center")
    axes.set(xticks=[], yticks=[])
    axes.grid(False)


def draw_error_contours(
    axes: Axes, results: Results, *, bins: int, ticks: Sequence[float] = (1, 2, 5), **lines: Any
) -> tuple[ContourSet, ContourSet]:
    """The model of the design: its errors over the space as filled contours, and their lines.

    The amplitude's axis is logarithmic: the error changes fastest at small amplitudes. The edge of
    the band is a thick line, with its value and for a legend, where the error reaches it.
    """
    data = error_table(results, "two_factor_design", "error_map", layer="map")
    grid = grid_arrays_of_table(data, "relative_error_percent")
    reach = float(np.abs(grid[2]).max())
    levels = MaxNLocator(nbins=bins, symmetric=True).tick_values(-reach, reach)
    limit_axes_to_grid(axes, grid)
    axes.set_yscale("log")
    style.set_plain_log_ticks(axes.yaxis, at=ticks)
    axes.yaxis.set_minor_locator(NullLocator())
    filled = axes.contourf(*grid, levels=levels, cmap=style.DIVERGING_COLOURMAP)
    drawn = axes.contour(*grid, levels=levels, linestyles="solid", **lines)
    band = float(data["band_percent"].iloc[0])
    if reach > band:
        thick: dict[str, Any] = {"colors": "black", "linestyles": "solid", "linewidths": 1.8}
        edge = axes.contour(*grid, levels=[-band, band], **thick)
        label_contours(axes, edge, lambda level: f"{signed_text(level, 3)} %")
        axes.plot([], [], "k", linewidth=1.8, label=f"±{band:g} %, the allowed band")
    return filled, drawn


def label_contours(axes: Axes, lines: ContourSet, form: Any) -> None:
    """Write a level on each line, upright on white: the sign of a level is no piece of the line.

    Labels that the rim of the axes would cut are not written.
    """
    for label in axes.clabel(lines, fontsize=6, fmt=form):
        at = axes.transAxes.inverted().transform(axes.transData.transform(label.get_position()))
        inside = bool((np.abs(at - 0.5) < 0.5 - np.array(CONTOUR_LABEL_MARGINS)).all())
        label.set(rotation=0, color="black", zorder=3, visible=inside)
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.6})


def label_points(axes: Axes, data: pd.DataFrame, *, labels: Iterable[str]) -> None:
    """Write a label beside each point, towards the middle of the axes, or above one at the top."""
    middle_h0 = sum(axes.get_xlim()) / 2
    low_hv, high_hv = axes.get_ylim()
    for h0_um, hv_um, label in zip(data["h0_um"], data["hv_um"], labels, strict=True):
        ha, right = ("left", 5) if h0_um < middle_h0 else ("right", -5)
        below = 0.4 < (hv_um - low_hv) / (high_hv - low_hv) < 0.7
        va, up = ("top", -4) if below else ("bottom", 4)
        look: dict[str, Any] = {"ha": ha, "va": va, "fontsize": 7, "zorder": 4}
        look["path_effects"] = [withStroke(linewidth=2, foreground="white")]
        annotate_at(axes, label, (h0_um, hv_um), (right, up), **look)


def add_3d_axes(
    figure: Figure,
    *,
    bottom: float = 0.0,
    labels: Sequence[str] = (*GAP_AMPLITUDE_LABELS.values(), "mean force $F$ (N)"),
    azimuth_deg: float = -132,
    pads: tuple[float, float] = (-5, -2),
    ticks: int = 5,
) -> Axes3D:
    """Axes in space that fill the figure; they do not take part in the usual layout.

    By default of force over gap and amplitude, seen so that no part of the surface hides another.

    Args:
        bottom: where they begin, a share of the figure's height.
        pads: from the axes to labels and to numbers.
        ticks: along each axis, at most.
    """
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.025, bottom, 0.935, 1 - bottom), projection="3d")
    assert isinstance(axes, Axes3D)
    axes.set_box_aspect((1.2, 1.2, 0.85), zoom=1.0)
    axes.view_init(elev=24, azim=azimuth_deg)
    axes.computed_zorder = False  # so that points can stand in front of the mesh
    axes.tick_params(pad=pads[1])
    for axis, label in zip((axes.xaxis, axes.yaxis, axes.zaxis), labels, strict=True):
        axis.set_label_text(label)
        axis.labelpad = pads[0]
        axis.set_pane_color((1, 1, 1, 0))
        axis.set_major_locator(MaxNLocator(nbins=ticks, steps=[1, 2, 5, 10]))
    return axes


def draw_mesh(axes: Axes3D, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> None:
    """Draw a mesh of shape (m, n) coloured by its height z."""
    colours = mpl.colormaps[style.SEQUENTIAL_COLOURMAP](mpl.colors.Normalize()(z))
    colours[..., :3] = 0.45 * colours[..., :3] + 0.55  # light, so that points stand out
    lines: dict[str, Any] = {"edgecolor": "0.4", "linewidth": 0.25, "shade": False, "zorder": 1}
    lines |= dict(zip(("rcount", "ccount"), z.shape, strict=True))
    axes.plot_surface(x, y, z, facecolors=colours, **lines)


def draw_force_mesh(axes: Axes3D, data: pd.DataFrame) -> None:
    """Draw a grid of rows h0_um, hv_um, force_n as a mesh."""
    hv, h0, force = grid_arrays_of_table(data, "force_n", x="hv_um", y="h0_um")
    x, y = np.meshgrid(h0, hv, indexing="ij")
    draw_mesh(axes, x, y, force)


def draw_force_points(axes: Axes3D, data: pd.DataFrame, **look: Any) -> None:
    """Draw rows h0_um, hv_um, force_n as dots in front of the mesh."""
    usual: dict[str, Any] = {"s": 11, "edgecolor": "black", "linewidth": 0.5, "zorder": 5}
    points = (data[name] for name in ("h0_um", "hv_um", "force_n"))
    axes.scatter(*points, depthshade=False, **usual | look)
