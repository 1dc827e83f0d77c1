"""Data of Figure 14: relative error of the fit on the optimal design, at the screen's points."""

from __future__ import annotations

import pandas as pd

from reporting.figure_data.common import Inputs
from reporting.figure_data.errors import error_note, error_table
from reporting.pages.notes import simulations_note
from squeezefilm.io.tables import read_ok_forces
from squeezefilm.models.fitted import read_fit
from squeezefilm.studies.config import Config

INPUTS = ("fit", "forces", "errors", "validation", "device")
SECTIONS: tuple[str, ...] = ()


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """One row per control point."""
    fit, forces = read_fit(inputs["fit"]), read_ok_forces(inputs["forces"])
    note = (
        f"{error_note(inputs['validation'], fit=f'Fit on {fit.points} points')} "
        f"{simulations_note(inputs['device'], forces)}"
    )
    data = error_table(inputs["errors"], inputs["validation"], layer="control")
    return data.assign(note=note)
