"""Figure 10: the first pattern of optimal points.

First pattern of optimal points. Along the dashed lines of equal excursion ratio the model does not
change.
"""

import pandas as pd

from paper.figures.parts.patterns import draw, pattern_table
from reporting.figures.parts.tables import Inputs
from squeezefilm.config.loading import Config

__all__ = ["INPUTS", "build", "draw"]

INPUTS = {
    "plan": "simulations/screen/scenes.csv",
    "summary": "designs/two_factor.json",
}


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers design and ridge."""
    return pattern_table(inputs, order=0)
