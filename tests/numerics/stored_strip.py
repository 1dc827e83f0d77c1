"""Forces on a long strip by each equation, stored: what constants and terms are compared with."""

from pathlib import Path

import pandas as pd

TABLE = pd.read_csv(Path(__file__).parent / "data" / "strip_forces.csv", comment="#")


def strip_force(equation: str, *, epsilon: float, sigma: float, reynolds: float) -> float:
    """The mean force in p0 l0 per length of a stored film, by a column of the table."""
    numbers = {"epsilon": epsilon, "sigma": sigma, "reynolds": reynolds}
    (row,) = TABLE.index[(TABLE[list(numbers)] == list(numbers.values())).all(axis=1)]
    return float(TABLE.at[row, equation])
