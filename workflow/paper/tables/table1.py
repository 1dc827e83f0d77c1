"""Table I: parameters of the two-factor model.

From all simulations of the screen and from the points of the optimal design alone.
"""

from paper.tables import Inputs, PaperTable, parameters_table

INPUTS = {
    "first_fit": "fits/screen.json",
    "design_fit": "fits/two_factor_design.json",
    "design_on_first": "validation/two_factor_design_on_screen.json",
    "forces": "simulations/screen/forces.csv",
    "device": "simulations/device.json",
}


def build(inputs: Inputs) -> PaperTable:
    """The table, from the files named in INPUTS."""
    return parameters_table(
        inputs,
        {"optimal design": ("design_fit", "design_on_first")},
        title="Table I. Parameters of the two-factor model",
        control="screen",
    )
