"""Data of Figure 15: the finger's positions in the four-factor plan."""

from __future__ import annotations

import pandas as pd

from paper.figure_data import disc
from reporting.figure_data.common import Inputs
from squeezefilm.io.tables import read_scenes
from squeezefilm.studies.config import Config

INPUTS = ("plan",)
SECTIONS = ("actuator", "finger")


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
