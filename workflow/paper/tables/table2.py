"""Table II: the space of the experiment with four factors.

The ranges of gap and amplitude are the paper's, those of the finger's position our assumption.
"""

import pandas as pd

from paper.tables import Inputs, PaperTable
from squeezefilm.io.tables import read_scenes

INPUTS = {
    "screen": "simulations/screen/scenes.csv",
    "plan": "simulations/four_factor/scenes.csv",
}


def build(inputs: Inputs) -> PaperTable:
    """The table, from the files named in INPUTS."""
    screen, plan = read_scenes(inputs["screen"]), read_scenes(inputs["plan"])
    assumed = "our assumption: the paper's table is not legible to us"
    data = pd.DataFrame(
        [
            ("mean gap", "h0", "µm", *_range(screen["h0_m"], scale=1e6), "paper"),
            ("amplitude at the centre", "hv", "µm", *_range(screen["hv_m"], scale=1e6), "paper"),
            ("radial position", "φr", "mm", *_range(plan["phi_r_m"], scale=1e3), assumed),
            ("angular position", "φφ", "°", *_range(plan["phi_deg"], scale=1), assumed),
        ],
        columns=["factor", "symbol", "unit", "minimum", "maximum", "source"],
    )
    positions = len(plan[["phi_r_m", "phi_deg"]].drop_duplicates())
    return PaperTable(
        title="Table II. Space of the experiment with four factors",
        data=data,
        shown=data.assign(
            **{name: data[name].map("{:g}".format) for name in ("minimum", "maximum")}
        ),
        note=(
            f"{len(plan)} simulations at {positions} positions of the finger's centre; the finger "
            "stays on the actuator at each of them."
        ),
    )


def _range(column: pd.Series, *, scale: float) -> tuple[float, float]:
    return round(float(column.min()) * scale, 9), round(float(column.max()) * scale, 9)
