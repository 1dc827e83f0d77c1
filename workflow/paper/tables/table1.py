"""Table I: parameters of the two-factor model.

From all simulations of the screen and from the points of the optimal design alone.
"""

from __future__ import annotations

from paper.tables import Inputs, PaperTable, global_error, note, parameters, side_by_side
from squeezefilm.models.fitted import read_fit

INPUTS = {
    "first_fit": "fits/screen.json",
    "design_fit": "fits/two_factor_design.json",
    "design_on_first": "validation/two_factor_design_on_screen.json",
    "forces": "simulations/screen/forces.csv",
    "device": "simulations/device.json",
}


def build(inputs: Inputs) -> PaperTable:
    """The table, from the files named in INPUTS."""
    first, design = read_fit(inputs["first_fit"]), read_fit(inputs["design_fit"])
    design_error = global_error(inputs["design_on_first"])
    data = parameters(
        {"screen": (first, first.global_error), "optimal design": (design, design_error)},
        control=f"{first.points} points of the screen",
    )
    return PaperTable(
        title="Table I. Parameters of the two-factor model",
        data=data,
        shown=side_by_side(data),
        note=note(inputs),
    )
