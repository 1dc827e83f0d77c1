"""Data of the error map: relative error of the fit on the optimal design, on a dense grid."""

from __future__ import annotations

import pandas as pd

from reporting.figure_data.common import Inputs, plane_table
from reporting.figure_data.errors import error_note, error_table
from reporting.pages.notes import simulations_note
from squeezefilm.io.tables import read_ok_forces
from squeezefilm.models.fitted import read_fit
from squeezefilm.studies.config import Config

INPUTS = ("fit", "forces", "errors", "validation", "design_forces", "device")
SECTIONS: tuple[str, ...] = ()


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers map (the grid of control points) and design."""
    fit, forces = read_fit(inputs["fit"]), read_ok_forces(inputs["forces"])
    design = read_ok_forces(inputs["design_forces"])
    grid = error_table(inputs["errors"], inputs["validation"], layer="map")
    data = pd.concat(
        [grid, plane_table(design, layer="design").drop(columns="force_n")], ignore_index=True
    )
    note = (
        f"{error_note(inputs['validation'], fit=f'Fit on {fit.points} points')} "
        f"{simulations_note(inputs['device'], forces, design)}"
    )
    return data.assign(band_percent=grid["band_percent"].iloc[0], note=note)
