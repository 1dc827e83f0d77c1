"""Figure 15: the positions of the finger with four factors.

Positions of the finger's centre in the four-factor plan. The positions are this study's assumption.
"""

import pandas as pd
from matplotlib.figure import Figure

from paper.figures.parts import disc
from reporting.figures.parts import plane, style
from reporting.figures.parts.tables import Inputs
from squeezefilm.config.loading import Config
from squeezefilm.io.tables import read_scenes

INPUTS = {
    "plan": "simulations/four_factor/scenes.csv",
}


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """One row per position, with the number of points of the plan at it."""
    plan = read_scenes(inputs["plan"])
    positions = plan.groupby(["phi_r_m", "phi_deg"], as_index=False).size()
    note = (
        f"{len(plan)} simulations at {len(positions)} positions; the positions are our assumption, "
        "for those of the original are not legible to us."
    )
    return pd.DataFrame(
        {
            "phi_deg": positions["phi_deg"],
            "phi_r_mm": (positions["phi_r_m"] * 1e3).round(9),
            "points": positions["size"],
            "phi_r_limit_mm": disc.centre_limit_mm(config),
            "note": note,
        }
    )


def draw(data: pd.DataFrame) -> Figure:
    """One dot per position; the dashed line is the largest radius on the actuator."""
    figure = style.new_figure()
    axes = figure.subplots()
    axes.axhline(
        data["phi_r_limit_mm"].iloc[0],
        color=style.VERMILLION,
        linestyle=(0, (4, 2)),
        label="finger stays on the actuator at every angle",
    )
    look = {"markersize": 5, "markeredgewidth": 0.5}
    plane.dots(axes, data, x="phi_deg", y="phi_r_mm", fill=style.BLUE, **look)
    for angle in data["phi_deg"][data["phi_r_mm"] == 0]:
        axes.annotate(
            "centre: the same at every angle",
            (angle, 0),
            xytext=(8, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
        )
    top = 1.15 * max(data["phi_r_mm"].max(), data["phi_r_limit_mm"].max())
    axes.set_ylim(-0.06 * top, top)
    plane.set_up_positions(axes, data["phi_deg"], margin=1 / 15)
    figure.legend(loc="outside upper center", handlelength=1.8)
    style.add_note(figure, data)
    return figure
