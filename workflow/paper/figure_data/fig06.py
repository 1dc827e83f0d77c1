"""Data of Figure 6: the profile as a mesh."""

from __future__ import annotations

import pandas as pd

from paper.figure_data import disc
from reporting.figure_data.common import Inputs
from squeezefilm.studies.config import Config

INPUTS: tuple[str, ...] = ()
SECTIONS = ("actuator",)


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layer surface, on a polar grid."""
    surface = disc.profile_table(config, radii=17, angles=49)
    return surface.assign(note=disc.profile_note(config))
