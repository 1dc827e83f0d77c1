"""Figure 13: the model fitted to the optimal design.

The force model fitted to the points of the optimal design alone (mesh; black dots), and the control
points of the screen (white dots).
"""

from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import surface
from reporting.figures.parts.tables import Inputs, model_mesh, plane_table
from reporting.pages.notes import percent, simulations_note
from squeezefilm.config.loading import Config
from squeezefilm.io.tables import read_json, read_ok_forces
from squeezefilm.models.fitted import number, read_fit

INPUTS = {
    "design_forces": "simulations/two_factor_design/forces.csv",
    "fit": "fits/two_factor_design.json",
    "control_forces": "simulations/screen/forces.csv",
    "validation": "validation/two_factor_design_on_screen.json",
    "device": "simulations/device.json",
}


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers model, design and control (the screen)."""
    design = read_ok_forces(inputs["design_forces"])
    control = read_ok_forces(inputs["control_forces"])
    fit = read_fit(inputs["fit"])
    error = number(read_json(inputs["validation"]), "global_error", inputs["validation"])
    data = pd.concat(
        [
            model_mesh(fit, control),
            plane_table(control, layer="control"),
            plane_table(design, layer="design"),
        ],
        ignore_index=True,
    )
    note = (
        f"Fit on {fit.points} points; on the {len(control)} control points: global error "
        f"{percent(error)}. {simulations_note(inputs['device'], design, control)}"
    )
    return data.assign(note=note)


def draw(data: pd.DataFrame) -> Figure:
    """Layers model (a mesh), control (white dots) and design (black dots)."""
    looks: dict[str, dict[str, Any]] = {
        "control": {"color": "white", "label": "control point"},
        "design": {"color": "black", "label": "design point", "s": 26},
    }
    return surface.model_and_points(data, looks)
