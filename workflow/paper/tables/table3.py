"""Table III: parameters of the four-factor model.

From all simulations of the plan and from the points of two optimal designs alone.
"""

from __future__ import annotations

from paper.tables import Inputs, PaperTable, global_error, note, parameters, side_by_side
from squeezefilm.models.fitted import read_fit

INPUTS = {
    "first_fit": "fits/four_factor.json",
    "design_fit": "fits/four_factor_design.json",
    "distinct_fit": "fits/four_factor_design_distinct.json",
    "design_on_first": "validation/four_factor_design_on_four_factor.json",
    "distinct_on_first": "validation/four_factor_design_distinct_on_four_factor.json",
    "forces": "simulations/four_factor/forces.csv",
    "device": "simulations/device.json",
}


def build(inputs: Inputs) -> PaperTable:
    """The table, from the files named in INPUTS."""
    first = read_fit(inputs["first_fit"])
    fits = {
        "plan": (first, first.global_error),
        "optimal design, the paper's form": (
            read_fit(inputs["design_fit"]),
            global_error(inputs["design_on_first"]),
        ),
        "optimal design, distinct scenes": (
            read_fit(inputs["distinct_fit"]),
            global_error(inputs["distinct_on_first"]),
        ),
    }
    data = parameters(fits, control=f"{first.points} points of the plan")
    return PaperTable(
        title="Table III. Parameters of the four-factor model",
        data=data,
        shown=side_by_side(data),
        note=(
            f"{note(inputs)} φφ in degrees and φr in metres. The paper's criterion takes "
            "one scene, a centred finger at two angles, for two points; the other design does not."
        ),
    )
