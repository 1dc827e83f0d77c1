"""Figure 6: the model of the surface's displacement as a mesh."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures import style, surface

COLUMNS = ("layer", "radius_mm", "angle_deg", "x_mm", "y_mm", "amplitude_ratio", "note")


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
