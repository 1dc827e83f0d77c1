"""Data of Figure 8: the model fitted to the screen, and the simulated forces."""

from __future__ import annotations

import pandas as pd

from reporting.figure_data.common import Inputs, model_mesh, plane_table
from reporting.pages.notes import percent, simulations_note
from squeezefilm.io.tables import read_ok_forces
from squeezefilm.models.fitted import read_fit
from squeezefilm.studies.config import Config

INPUTS = ("forces", "fit", "device")
SECTIONS: tuple[str, ...] = ()


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers model and simulation."""
    forces, fit = read_ok_forces(inputs["forces"]), read_fit(inputs["fit"])
    data = pd.concat(
        [model_mesh(fit, forces), plane_table(forces, layer="simulation")], ignore_index=True
    )
    note = (
        f"Fit on {fit.points} points: global error {percent(fit.global_error)}. "
        f"{simulations_note(inputs['device'], forces)}"
    )
    return data.assign(note=note)
