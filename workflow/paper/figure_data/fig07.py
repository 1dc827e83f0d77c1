"""Data of Figure 7: the points of the screen."""

from __future__ import annotations

import pandas as pd

from reporting.figure_data.common import Inputs, add_limits, plane_table
from squeezefilm.io.tables import read_scenes
from squeezefilm.studies.config import Config

INPUTS = ("plan",)
SECTIONS: tuple[str, ...] = ()


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """One row per point of the screen's plan."""
    screen = read_scenes(inputs["plan"])
    gaps, amplitudes = screen["h0_m"].nunique(), screen["hv_m"].nunique()
    note = (
        f"{len(screen)} simulations: {gaps} gaps × {amplitudes} amplitudes (our reading of the "
        "original figure), finger centred."
    )
    return add_limits(plane_table(screen, layer="screen"), screen).assign(note=note)
