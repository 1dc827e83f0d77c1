"""Figure 8: the model fitted to the screen.

The force model of eq. (7) fitted to all simulations of the screen (mesh), and the simulated forces
(dots).
"""

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import style, surface
from reporting.figures.parts.tables import Inputs, model_mesh, plane_table
from reporting.pages.notes import percent, simulations_note
from squeezefilm.config.loading import Config
from squeezefilm.io.tables import read_ok_forces
from squeezefilm.models.fitted import read_fit

INPUTS = {
    "forces": "simulations/screen/forces.csv",
    "fit": "fits/screen.json",
    "device": "simulations/device.json",
}


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


def draw(data: pd.DataFrame) -> Figure:
    """Layers model (a mesh) and simulation (dots)."""
    look = {"color": style.VERMILLION, "label": "simulation"}
    return surface.model_and_points(data, {"simulation": look})
