"""Data of Figure 13: the model fitted to the optimal design, with design and control points."""

from __future__ import annotations

import pandas as pd

from reporting.figure_data.common import Inputs, model_mesh, plane_table
from reporting.pages.notes import percent, simulations_note
from squeezefilm.io.tables import read_json, read_ok_forces
from squeezefilm.models.fitted import number, read_fit
from squeezefilm.studies.config import Config

INPUTS = ("design_forces", "fit", "control_forces", "validation", "device")
SECTIONS: tuple[str, ...] = ()


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
