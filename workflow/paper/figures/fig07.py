"""Figure 7: the screen: the simulations of the first plan.

Space of the experiment: the simulations of the first plan, a screen in mean gap and amplitude with
the finger centred.
"""

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import plane, style
from reporting.figures.parts.tables import Inputs, add_limits, plane_table
from squeezefilm.config.loading import Config
from squeezefilm.io.tables import read_scenes

INPUTS = {
    "plan": "simulations/screen/scenes.csv",
}


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """One row per point of the screen's plan."""
    screen = read_scenes(inputs["plan"])
    gaps, amplitudes = screen["h0_m"].nunique(), screen["hv_m"].nunique()
    note = (
        f"{len(screen)} simulations: {gaps} gaps × {amplitudes} amplitudes (our reading of the "
        "original figure), finger centred."
    )
    return add_limits(plane_table(screen, layer="screen"), screen).assign(note=note)


def draw(data: pd.DataFrame) -> Figure:
    """One dot per simulation."""
    figure = style.new_figure()
    axes = figure.subplots()
    plane.dots(axes, data, fill=style.BLUE, markersize=4, markeredgewidth=0.5)
    plane.set_up(axes, data)
    style.add_note(figure, data)
    return figure
