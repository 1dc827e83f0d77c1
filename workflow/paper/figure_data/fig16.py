"""Data of Figure 16: the optimal points in four dimensions, in both forms of the criterion."""

from __future__ import annotations

import pandas as pd

from reporting.figure_data.common import Inputs, add_limits, plane_table
from squeezefilm.io.tables import read_design, read_scenes
from squeezefilm.studies.config import Config

INPUTS = ("screen", "plan", "design", "distinct")
SECTIONS: tuple[str, ...] = ()


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """One row per point of each form's design, numbered from 1."""
    designs = {
        "the paper's criterion": read_design(inputs["design"]),
        "physically distinct points": read_design(inputs["distinct"]),
    }
    screen, plan = read_scenes(inputs["screen"]), read_scenes(inputs["plan"])
    parts = [
        plane_table(design, layer="design").assign(
            form=form,
            point=range(1, len(design) + 1),
            phi_r_mm=(design["phi_r_m"] * 1e3).round(9),
            phi_deg=design["phi_deg"].round(9),
        )
        for form, design in designs.items()
    ]
    data = add_limits(pd.concat(parts, ignore_index=True), screen)
    paper = designs["the paper's criterion"]
    note = (
        "Numbers tell the points of a design apart. At radius 0 every angle is one and the same "
        f"scene: of the {len(paper)} points by the paper's criterion {distinct_scenes(paper)} are "
        "different scenes. Where a point lies on its line of equal hv/h0 is left free."
    )
    return data.assign(
        phi_r_max_mm=round(float(plan["phi_r_m"].max()) * 1e3, 9),
        phi_max_deg=plan["phi_deg"].max(),
        note=note,
    )


def distinct_scenes(design: pd.DataFrame) -> int:
    """How many different scenes a design has: at the centre the angle makes no difference."""
    centred = design["phi_r_m"] < 1e-9
    scenes = pd.DataFrame(
        {
            "h0_um": (design["h0_m"] * 1e6).round(3),
            "hv_um": (design["hv_m"] * 1e6).round(3),
            "phi_r_mm": (design["phi_r_m"] * 1e3).round(3),
            "phi_deg": design["phi_deg"].round(3).where(~centred, 0.0),
        }
    )
    return len(scenes.drop_duplicates())
