"""Figure 13: the model fitted to the optimal design, its points black, control points white."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures import style, surface

COLUMNS = ("layer", "h0_um", "hv_um", "force_n", "note")


def draw(data: pd.DataFrame) -> Figure:
    """Layers model (a mesh), control (white dots) and design (black dots)."""
    figure = style.new_figure(height_in=3.1)
    bottom = style.add_note(figure, data)
    axes = surface.add_force_axes(figure, bottom=bottom)
    surface.force_mesh(axes, style.rows(data, "model"))
    surface.force_points(axes, style.rows(data, "control"), color="white", label="control point")
    surface.force_points(
        axes, style.rows(data, "design"), color="black", s=26, label="design point"
    )
    surface.add_legend(axes)
    return figure
