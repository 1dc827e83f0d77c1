"""The paper's figures by their places among a study's results."""

from squeezefilm_workflow.paper.figures import four_factor, patterns, two_factor, vibration
from squeezefilm_workflow.reporting.figures import DrawFunction, models

FIGURES: dict[str, DrawFunction] = {
    f"figures/{function.__name__}": function
    for function in (
        *(vibration.fig05, vibration.fig06, two_factor.fig07),
        *(patterns.fig09, patterns.fig10, patterns.fig11),
        *(two_factor.fig13, two_factor.fig14),
        *(four_factor.fig15, four_factor.fig16),
    )
}
FIGURES |= {"figures/fig08": models.fitted_model, "figures/fig12": models.design}
