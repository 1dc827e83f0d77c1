"""The paper's figures by their places among a study's results."""

from paper.figures import four_factor, patterns, two_factor, vibration
from reporting.figures import Draw

FIGURES: dict[str, Draw] = {
    f"figures/{function.__name__}": function
    for function in (
        *(vibration.fig05, vibration.fig06, two_factor.fig07, two_factor.fig08),
        *(patterns.fig09, patterns.fig10, patterns.fig11),
        *(two_factor.fig12, two_factor.fig13, two_factor.fig14),
        *(four_factor.fig15, four_factor.fig16),
    )
}
