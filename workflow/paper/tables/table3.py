"""Table III: parameters of the four-factor model.

From all simulations of the plan and from the points of two optimal designs alone.
"""

from paper.tables import Inputs, PaperTable, parameters_table

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
    return parameters_table(
        inputs,
        {
            "optimal design, the paper's form": ("design_fit", "design_on_first"),
            "optimal design, distinct scenes": ("distinct_fit", "distinct_on_first"),
        },
        title="Table III. Parameters of the four-factor model",
        control="plan",
        more=" φφ in degrees and φr in metres. The paper's criterion takes one scene, a centred "
        "finger at two angles, for two points; the other design does not.",
    )
