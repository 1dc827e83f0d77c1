"""Figure 8: the model fitted to the screen as a mesh, the simulated forces as dots."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures import style, surface

COLUMNS = ("layer", "h0_um", "hv_um", "force_n", "note")


def draw(data: pd.DataFrame) -> Figure:
    """Layers model (a mesh) and simulation (dots)."""
    figure = style.new_figure(height_in=3.1)
    bottom = style.add_note(figure, data)
    axes = surface.add_force_axes(figure, bottom=bottom)
    surface.force_mesh(axes, style.rows(data, "model"))
    surface.force_points(
        axes, style.rows(data, "simulation"), color=style.VERMILLION, label="simulation"
    )
    surface.add_legend(axes)
    return figure
