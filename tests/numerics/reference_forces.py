"""Forces that the solver has given once for the paper's plans, for tests of what follows them."""

from pathlib import Path

import numpy as np
import pandas as pd

from squeezefilm.models.data import Factors
from squeezefilm.models.force_model import get_model
from squeezefilm.tables import FACTOR_COLUMNS

TWO_FACTOR, FOUR_FACTOR = get_model("two_factor"), get_model("four_factor")
# Where the searches for the paper's forms (7) and (14) end on these plans (tests/unit/test_fit.py).
SCREEN_THETA = (7.6240, 1.91659, -1.001314)
FOUR_FACTOR_THETA = (7.3609, 2.07664, -1.000252, 0.016642, -81.115)
FOLDER = Path(__file__).resolve().parents[1] / "reference"


def reference_table(plan: str) -> pd.DataFrame:
    """The table of ``screen`` or ``four_factor``."""
    return pd.read_csv(FOLDER / f"{plan}_forces.csv", dtype={"point_id": str})


def reference_forces(plan: str) -> tuple[Factors, np.ndarray]:
    """The plan's factors and forces in newtons."""
    table = reference_table(plan)
    factors = Factors.of(**{name: table[name] for name in FACTOR_COLUMNS})
    return factors, table["force_n"].to_numpy()
