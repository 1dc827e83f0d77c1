"""Figure 6: the same as a mesh.

The model of eq. (2) for the displacement of the actuator's surface, as a mesh. The measured points
of the original figure are not available.
"""

import pandas as pd
from matplotlib.figure import Figure

from paper.figures.parts import disc
from reporting.figures.parts import style, surface
from reporting.figures.parts.tables import Inputs
from squeezefilm.config.loading import Config

INPUTS: dict[str, str] = {}


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layer surface, on a polar grid."""
    surface = disc.profile_table(config, radii=17, angles=49)
    return surface.assign(note=disc.profile_note(config))


def draw(data: pd.DataFrame) -> Figure:
    """The profile as a mesh in polar coordinates; layer surface."""
    figure = style.new_figure(height_in=3.1)
    bottom = style.add_note(figure, data)
    axes = surface.add_axes(
        figure,
        labels=("$x$ (mm)", "$y$ (mm)", "amplitude $h_a/h_v$ (–)"),
        azimuth_deg=-60,
        bottom=bottom,
    )
    table = style.rows(data, "surface")
    x, y, amplitude = (
        table.pivot(index="radius_mm", columns="angle_deg", values=name).to_numpy()
        for name in ("x_mm", "y_mm", "amplitude_ratio")
    )
    surface.mesh(axes, x, y, amplitude)
    return figure
