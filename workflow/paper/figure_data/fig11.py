"""Data of Figure 11: the second-best pattern of three points."""

from __future__ import annotations

import pandas as pd

from paper.figure_data import searches
from reporting.figure_data.common import Inputs
from squeezefilm.studies.config import Config

INPUTS = searches.INPUTS
SECTIONS: tuple[str, ...] = ()


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers design and ridge; layer absent where the searches found one pattern only."""
    return searches.pattern_table(inputs, order=1)
