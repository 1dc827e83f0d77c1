"""A pressure field in pictures: eight phases on a sheet, or the whole period as an animation."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from squeezefilm.io.atomic import whole_file
from squeezefilm.io.errors import InputError, needing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage
    from xarray import DataArray, Dataset

ANIMATED = ".gif"
SHOWN = 8
FRAMES_PER_SECOND = 16
KPA = 1e-3
NEEDED = {"overpressure": ("phase", "y", "x"), "gap": ("phase", "y", "x")}


def read_field(path: Path | str) -> Dataset:
    """A field as `squeezefilm pressure` writes it.

    Raises InputError naming the file, where it cannot be read or holds something else.
    """
    with needing("fields", what="a pressure field"):
        import xarray
    try:
        with xarray.open_dataset(path, engine="scipy") as file:
            field = file.load()
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except Exception as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{path}: not readable as NetCDF: {reason}") from None
    for name, axes in NEEDED.items():
        if name not in field or field[name].dims != axes:
            raise InputError(
                f"{path}: no {name} over {', '.join(axes)}, as `squeezefilm pressure` writes it"
            )
    missing = [name for name in ("h0_m", "hv_m") if name not in field.attrs]
    if missing:
        raise InputError(f"{path}: the attribute {missing[0]} is missing")
    if not np.isfinite(field["overpressure"]).any():
        raise InputError(f"{path}: there is no pressure in it")
    return field


def draw_sheet(field: Dataset) -> Figure:
    """The overpressure at SHOWN phases and in the mean; means over the pad, over the period."""
    from reporting.figures.parts import style

    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=6.0)
    upper, lower = figure.subfigures(2, 1, height_ratios=(2, 1.1), squeeze=False).ravel()
    pressure = KPA * field["overpressure"]
    reach = float(np.abs(pressure).max()) or 1.0
    step = max(1, pressure.sizes["phase"] // SHOWN)
    shown = list(range(0, pressure.sizes["phase"], step))[:SHOWN]
    pictures = upper.subplots(2, SHOWN // 2)
    for axes, instant in zip(pictures.flat, shown, strict=False):
        image = _picture(axes, pressure[instant], reach)
        axes.set_title(f"{float(field['phase'][instant]):.0f}°")
    for axes in list(pictures.flat)[len(shown) :]:
        axes.set_axis_off()
    upper.colorbar(image, ax=pictures, label="overpressure (kPa)", shrink=0.8)
    middle, period = lower.subplots(1, 2, width_ratios=(1, 1.8))
    mean = pressure.mean("phase")
    image = _picture(middle, mean, float(np.abs(mean).max()) or 1.0)
    middle.set_title("mean over the period")
    lower.colorbar(image, ax=middle, label="kPa", shrink=0.8)
    _over_the_period(period, field, style.BLUE, style.VERMILLION)
    figure.suptitle(_title(field))
    return figure


def save_animation(field: Dataset, path: Path | str) -> None:
    """The whole period as a GIF, which goes round without a jump."""
    from matplotlib.animation import FuncAnimation, PillowWriter

    from reporting.figures.parts import style

    figure = style.new_figure(height_in=3.2)
    axes = figure.subplots()
    pressure = KPA * field["overpressure"]
    image = _picture(axes, pressure[0], float(np.abs(pressure).max()) or 1.0)
    figure.colorbar(image, ax=axes, label="overpressure (kPa)")
    title = axes.set_title("")
    figure.suptitle(_title(field))

    def show(instant: int) -> tuple[object, ...]:
        image.set_data(pressure[instant])
        title.set_text(f"phase {float(field['phase'][instant]):.0f}°")
        return image, title

    style.settle(figure)  # once, not for every frame
    film = FuncAnimation(figure, show, frames=pressure.sizes["phase"])  # type: ignore[arg-type]
    with TemporaryDirectory() as folder:  # the writer goes by a name's end
        film.save(f"{folder}/film{ANIMATED}", PillowWriter(fps=FRAMES_PER_SECOND), dpi=150)
        data = Path(folder, f"film{ANIMATED}").read_bytes()
    with whole_file(path) as part:
        part.write_bytes(data)


def _picture(axes: Axes, values: DataArray, reach: float) -> AxesImage:
    """One instant of the field, with x to the right and y upwards, in millimetres."""
    from reporting.figures.parts import style

    x, y = (1e3 * values[name].to_numpy() for name in ("x", "y"))
    image = axes.imshow(
        values.to_numpy(),
        extent=(x[0], x[-1], y[0], y[-1]),
        origin="lower",
        interpolation="bilinear",
        cmap=style.DIVERGING,
        vmin=-reach,
        vmax=reach,
    )
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")
    axes.label_outer()
    return image


def _over_the_period(axes: Axes, field: Dataset, of_pressure: str, of_gap: str) -> None:
    """Overpressure and gap, each the mean over the pad."""
    phase = np.append(field["phase"].to_numpy(), 360.0)
    for target, name, factor, label, colour in (
        (axes, "overpressure", KPA, "mean overpressure (kPa)", of_pressure),
        (axes.twinx(), "gap", 1e6, "mean gap (µm)", of_gap),
    ):
        mean = factor * _over_the_pad(field[name])
        target.plot(phase, np.append(mean, mean[0]), color=colour)
        target.set_ylabel(label, color=colour)
    axes.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 45))
    axes.set_xlabel("phase (°): the surface goes down from 0°")


def _over_the_pad(values: DataArray) -> np.ndarray:
    """Mean over the places of a field, those of the rim counted by half, outside the pad not."""
    weights = np.ones(values.shape[1:])
    weights[[0, -1]] /= 2
    weights[:, [0, -1]] /= 2
    inside = np.isfinite(values.to_numpy())
    return np.asarray(
        (np.where(inside, values.to_numpy(), 0) * weights).sum(axis=(1, 2))
        / (inside * weights).sum(axis=(1, 2))
    )


def _title(field: Dataset) -> str:
    text = f"h0 {1e6 * field.attrs['h0_m']:.4g} µm, hv {1e6 * field.attrs['hv_m']:.4g} µm"
    if "frequency_hz" in field.attrs:
        text += f", {1e-3 * field.attrs['frequency_hz']:.4g} kHz"
    return text
