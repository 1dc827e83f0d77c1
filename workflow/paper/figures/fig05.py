"""Figure 5: the model of the vibration over the surface.

Amplitude of vibration over the top surface of the actuator, as a share of its maximum at the
centre, by the model of eq. (2). Dashed: the finger's centre may move within this circle without the
finger leaving the surface at any angle. The measured amplitudes of the original figure are not
available.
"""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from paper.figures.parts import disc
from reporting.figures.parts import style
from reporting.figures.parts.tables import Inputs
from squeezefilm.config.loading import Config
from squeezefilm.studies.study import finger_of

INPUTS: dict[str, str] = {}


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers surface (polar grid), centre_limit (a circle) and finger (its outline, centred)."""
    finger, limit_mm = finger_of(config), disc.centre_limit_mm(config)
    rim = np.round(np.array(finger.outline()) * 1e3, 9)
    closed = np.vstack([rim, rim[:1]])
    outline = pd.DataFrame({"layer": "finger", "x_mm": closed[:, 0], "y_mm": closed[:, 1]})
    angle_deg = np.linspace(0, 360, 121)
    circle = pd.DataFrame(
        {
            "layer": "centre_limit",
            "radius_mm": limit_mm,
            "angle_deg": angle_deg,
            "x_mm": np.round(limit_mm * np.cos(np.radians(angle_deg)), 9),
            "y_mm": np.round(limit_mm * np.sin(np.radians(angle_deg)), 9),
        }
    )
    surface = disc.profile_table(config, radii=41, angles=61)
    note = (
        f"{disc.profile_note(config)} The finger, {finger.length_x_m * 1e3:g} mm × "
        f"{finger.length_y_m * 1e3:g} mm, stays on the "
        f"disc at every angle while its centre is within {limit_mm:.2f} mm."
    )
    return pd.concat([surface, circle, outline], ignore_index=True).assign(note=note)


def draw(data: pd.DataFrame) -> Figure:
    """The profile seen from above; layers surface, centre_limit (dashed) and finger."""
    figure = style.new_figure(height_in=3.5)
    axes = figure.subplots()
    surface = style.rows(data, "surface")
    x, y, amplitude = (
        surface.pivot(index="radius_mm", columns="angle_deg", values=name).to_numpy()
        for name in ("x_mm", "y_mm", "amplitude_ratio")
    )
    levels = np.linspace(-1, 1, 41)
    levels = levels[(levels >= amplitude.min() - 0.05) & (levels <= amplitude.max() + 0.01)]
    filled = axes.contourf(x, y, amplitude, levels=levels, cmap=style.SEQUENTIAL)
    if amplitude.min() < 0 < amplitude.max():
        node = axes.contour(x, y, amplitude, levels=[0], colors="white", linewidths=0.7)
        axes.clabel(node, fmt={0: "$h_a = 0$"}, fontsize=6, manual=[(0, float(y.max()))])
    limit, finger = style.rows(data, "centre_limit"), style.rows(data, "finger")
    axes.plot(
        limit["x_mm"],
        limit["y_mm"],
        color=style.VERMILLION,
        linestyle=(0, (4, 2)),
        linewidth=1.4,
        label="limit of the finger's centre",
    )
    axes.plot(finger["x_mm"], finger["y_mm"], color="black", label="finger, centred")
    axes.set_aspect("equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 5, 10]))
    reach = 1.04 * surface["radius_mm"].max()
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_xlabel("$x$ (mm)")
    axes.set_ylabel("$y$ (mm)")
    bar = figure.colorbar(filled, ax=axes, shrink=0.8, pad=0.02)
    bar.set_label("amplitude $h_a/h_v$ (–)")
    bar.set_ticks([tick for tick in np.arange(-0.2, 1.01, 0.2) if tick >= levels[0]])
    figure.legend(loc="outside upper center", ncols=2, handlelength=1.8, columnspacing=1.0)
    style.add_note(figure, data)
    return figure
