"""A pressure field in pictures: eight phases on a sheet, or the whole period as an animation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from squeezefilm.errors import InputError, imports_from_extra
from squeezefilm.files import atomic_file
from squeezefilm_workflow.reporting.figures import style

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

ANIMATION_SUFFIX = ".gif"
SHOWN_PHASE_COUNT = 8
FRAMES_PER_SECOND = 16
FIELD_DIMENSION_NAMES = ("phase", "y", "x")


def draw_pressure_field(path: Path | str, files: Sequence[Path]) -> None:
    """Draw a field, an animation where a file's name ends in .gif, else a sheet.

    Raises InputError naming the file, where it cannot be read or holds something else.
    """
    field = read_pressure_field(path)
    with style.figure_style():
        for file in files:
            if file.suffix == ANIMATION_SUFFIX:
                save_animation(field, file)
            else:
                style.save_figure(pressure_figure(field), [file])


def read_pressure_field(path: Path | str) -> Dataset:
    """A field as `squeezefilm pressure` writes it, the gauge pressure in kPa.

    Raises InputError naming the file, where it cannot be read or holds something else.
    """
    with imports_from_extra("fields", what="a pressure field"):
        import xarray
    try:
        field = xarray.load_dataset(path, engine="scipy")
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except Exception as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{path}: not readable as NetCDF: {reason}") from None
    for name in ("gauge_pressure", "gap"):
        if name not in field or field[name].dims != FIELD_DIMENSION_NAMES:
            raise InputError(
                f"{path}: no {name} over {', '.join(FIELD_DIMENSION_NAMES)}, as `squeezefilm "
                "pressure` writes it"
            )
    if missing := {"h0_m", "hv_m", "frequency_hz"} - set(field.attrs):
        raise InputError(f"{path}: the attribute {min(missing)} is missing")
    if not np.isfinite(field["gauge_pressure"]).any():
        raise InputError(f"{path}: there is no pressure in it")
    return field.assign(gauge_pressure=1e-3 * field["gauge_pressure"])


def pressure_figure(field: Dataset) -> Figure:
    """The gauge pressure at SHOWN_PHASE_COUNT phases and in the mean; means over the pad, over the
    period.
    """
    figure = style.new_figure(wide=True, height_in=6.0)
    upper, lower = figure.subfigures(2, 1, height_ratios=(2, 1.1), squeeze=False).ravel()
    pressure = field["gauge_pressure"]
    shown = pressure[:: max(1, pressure.sizes["phase"] // SHOWN_PHASE_COUNT)][:SHOWN_PHASE_COUNT]
    pictures = upper.subplots(2, SHOWN_PHASE_COUNT // 2)
    for axes in pictures.flat[len(shown) :]:
        axes.set_axis_off()
    for axes, values in zip(pictures.flat, shown, strict=False):
        image = _draw_instant(axes, values, reach=_colour_scale_limit(pressure))
        axes.set_title(f"{float(values['phase']):.0f}°")
    upper.colorbar(image, ax=pictures, label="gauge pressure (kPa)", shrink=0.8)
    middle, period = lower.subplots(1, 2, width_ratios=(1, 1.8))
    mean = pressure.mean("phase")
    image = _draw_instant(middle, mean, reach=_colour_scale_limit(mean))
    middle.set_title("mean over the period")
    lower.colorbar(image, ax=middle, label="kPa", shrink=0.8)
    _draw_means_over_period(period, field)
    figure.suptitle(_figure_title(field))
    return figure


def save_animation(field: Dataset, path: Path | str) -> None:
    """The whole period as a GIF, which goes round without a jump."""
    figure, axes = style.subplots(height_in=3.2)
    pressure = field["gauge_pressure"]
    image = _draw_instant(axes, pressure[0], reach=_colour_scale_limit(pressure))
    figure.colorbar(image, ax=axes, label="gauge pressure (kPa)")
    title = axes.set_title("")
    figure.suptitle(_figure_title(field))

    def draw_frame(instant: int) -> tuple[object, ...]:
        image.set_data(pressure[instant])
        title.set_text(f"phase {float(field['phase'][instant]):.0f}°")
        return image, title

    style.freeze_layout(figure)  # once, not for every frame
    film = FuncAnimation(figure, draw_frame, frames=pressure.sizes["phase"])  # type: ignore[arg-type]
    with atomic_file(path) as part:
        named = part.with_suffix(ANIMATION_SUFFIX)  # the writer goes by a name's end
        film.save(named, PillowWriter(fps=FRAMES_PER_SECOND), dpi=150)
        named.rename(part)


def _colour_scale_limit(pressure: DataArray) -> float:
    """The end of a scale about zero."""
    return float(np.abs(pressure).max()) or 1.0


def _draw_instant(axes: Axes, values: DataArray, *, reach: float) -> AxesImage:
    """One instant of the field, with x to the right and y upwards, in millimetres."""
    x, y = (1e3 * values[name].to_numpy() for name in ("x", "y"))
    scale: dict[str, Any] = {"cmap": style.DIVERGING_COLOURMAP, "vmin": -reach, "vmax": reach}
    scale |= {"extent": (x[0], x[-1], y[0], y[-1]), "origin": "lower"}
    image = axes.imshow(values.to_numpy(), interpolation="bilinear", **scale)
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    axes.label_outer()
    return image


def _draw_means_over_period(axes: Axes, field: Dataset) -> None:
    """Gauge pressure and gap, each the mean over the pad: places of its rim count by half."""
    ends = [np.where(np.arange(n) % (n - 1) == 0, 0.5, 1) for n in field["gap"].shape[1:]]
    weights = field["gap"][0].copy(data=np.outer(*ends))
    for target, name, factor, label, colour in (
        (axes, "gauge_pressure", 1.0, "mean gauge pressure (kPa)", style.BLUE),
        (axes.twinx(), "gap", 1e6, "mean gap (µm)", style.VERMILLION),
    ):
        mean = factor * field[name].weighted(weights).mean(("x", "y")).to_numpy()
        target.plot([*field["phase"].to_numpy(), 360.0], [*mean, mean[0]], color=colour)
        target.set_ylabel(label, color=colour)
    axes.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    label = "phase (°): the surface goes down from 0°"
    axes.set(xlim=(0, 360), xticks=range(0, 361, 45), xlabel=label)


def _figure_title(field: Dataset) -> str:
    h0_um, hv_um = (1e6 * field.attrs[name] for name in ("h0_m", "hv_m"))
    title = f"h0 {h0_um:.4g} µm, hv {hv_um:.4g} µm, {1e-3 * field.attrs['frequency_hz']:.4g} kHz"
    position_mm = {axis: round(1e3 * field.attrs.get(f"pad_{axis}_m", 0.0), 9) for axis in "xy"}
    place = ", ".join(f"{axis} {value:.4g} mm" for axis, value in position_mm.items() if value)
    return f"{title}, pad at {place}" if place else title
