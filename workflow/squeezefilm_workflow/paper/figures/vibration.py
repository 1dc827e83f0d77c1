"""Figures 5 and 6: the model of the vibration over the actuator's disc."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from squeezefilm.config.study import Study
from squeezefilm_workflow.reporting.figures import parts, style
from squeezefilm_workflow.reporting.results import Results

DECIMALS_OF_COLUMN = {"radius_mm": 9, "x_mm": 9, "y_mm": 9, "amplitude_ratio": 12}
"""Of a table: the last ones differ from machine to machine."""


def fig05(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The profile seen from above; layers surface, centre_limit (dashed) and pad."""
    config = results.config
    pad, limit_mm = config.read_pad(), max_centre_distance_mm(config)
    edge_mm = 1e3 * pad.edge_points_m()
    outline = pd.DataFrame(np.vstack([edge_mm, edge_mm[:1]]), columns=["x_mm", "y_mm"])
    circle = _polar_table(np.array([limit_mm]), np.linspace(0, 360, 121))
    surface = profile_table(config, radii=41, angles=61)
    layers = {"surface": surface, "centre_limit": circle, "pad": outline}
    data = pd.concat([table.assign(layer=layer) for layer, table in layers.items()])
    figure, axes = style.subplots(height_in=3.1)
    x, y, amplitude = _polar_grid(surface)
    levels = np.linspace(-1, 1, 41)
    levels = levels[(levels >= amplitude.min() - 0.05) & (levels <= amplitude.max() + 0.01)]
    filled = axes.contourf(x, y, amplitude, levels=levels, cmap=style.SEQUENTIAL_COLOURMAP)
    if amplitude.min() < 0 < amplitude.max():
        node = axes.contour(x, y, amplitude, levels=[0], colors="white", linewidths=0.7)
        axes.clabel(node, fmt={0: "$h_a = 0$"}, fontsize=6, manual=[(0, float(y.max()))])
    look: dict[str, Any] = {
        "color": style.VERMILLION,
        "linestyle": style.DASHED_LINE,
        "linewidth": 1.4,
    }
    axes.plot(circle["x_mm"], circle["y_mm"], label="limit of the pad's centre", **look)
    axes.plot(outline["x_mm"], outline["y_mm"], color="black", label="pad, centred")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 5, 10]))
    reach = 1.04 * surface["radius_mm"].max()
    axes.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach))
    axes.set(xlabel="$x$ (mm)", ylabel="$y$ (mm)")
    label = "local amplitude $h_a/h_v$ (–)"
    bar = figure.colorbar(filled, ax=axes, shrink=0.8, pad=0.02, label=label)
    bar.set_ticks([tick for tick in np.arange(-0.2, 1.01, 0.2) if tick >= levels[0]])
    figure.legend(loc="outside upper center", ncols=2, handlelength=1.8, columnspacing=1.0)
    note = f"The pad's centre may be up to {limit_mm:.2f} mm from the actuator's."
    style.add_note(figure, note, results.validity_note)
    return figure, data.round(DECIMALS_OF_COLUMN)


def fig06(results: Results) -> tuple[Figure, pd.DataFrame]:
    """The profile as a mesh in polar coordinates."""
    data = profile_table(results.config, radii=17, angles=49)
    figure = style.new_figure(height_in=3.1)
    axes = parts.add_3d_axes(
        figure,
        bottom=style.add_note(figure, results.validity_note),
        labels=("$x$ (mm)", "$y$ (mm)", "local amplitude $h_a/h_v$ (–)"),
        azimuth_deg=-60,
    )
    parts.draw_mesh(axes, *_polar_grid(data))
    return figure, data.assign(layer="surface").round(DECIMALS_OF_COLUMN)


def _polar_grid(surface: pd.DataFrame) -> list[np.ndarray]:
    """x, y and the amplitude over radius (rows) and angle."""
    return [
        parts.grid_arrays_of_table(surface, name, x="angle_deg", y="radius_mm")[2]
        for name in ("x_mm", "y_mm", "amplitude_ratio")
    ]


def profile_table(config: Study, *, radii: int, angles: int) -> pd.DataFrame:
    """The profile on a polar grid over the disc."""
    radius_m = np.linspace(0, config.actuator.surface_radius_m, radii)
    table = _polar_table(1e3 * radius_m, np.linspace(0, 360, angles))
    positions_m = {f"{name}_m": table[f"{name}_mm"].to_numpy() / 1e3 for name in "xy"}
    s = config.read_profile().amplitude(**positions_m)
    return table.assign(amplitude_ratio=np.abs(s) if np.iscomplexobj(s) else s)


def _polar_table(radius_mm: np.ndarray, angle_deg: np.ndarray) -> pd.DataFrame:
    radius, angle = (
        coordinate.ravel() for coordinate in np.meshgrid(radius_mm, angle_deg, indexing="ij")
    )
    x_mm, y_mm = radius * np.cos(np.radians(angle)), radius * np.sin(np.radians(angle))
    return pd.DataFrame({"radius_mm": radius, "angle_deg": angle, "x_mm": x_mm, "y_mm": y_mm})


def max_centre_distance_mm(config: Study) -> float:
    """Largest distance of the pad's centre at which the pad is on the disc at every angle."""
    free_m = config.actuator.surface_radius_m - config.read_pad().max_radius_m
    return round(1e3 * float(free_m), 9)
