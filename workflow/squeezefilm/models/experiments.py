"""The factors of simulated experiments, put together from the tables of forces and of limits."""

from pathlib import Path

import numpy as np
import pandas as pd

from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import as_in
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import FACTOR_COLUMNS, LIMIT_COLUMNS
from squeezefilm.models.force_model import COLUMNS, ExpressionModel, Factors


def factors_of(points: pd.DataFrame, *, limits: Path | str | pd.DataFrame | None = None) -> Factors:
    """The factors of a table's rows, with the results of physics where their table is given.

    ``limits`` is what ``squeezefilm limits`` wrote for the same scenes, or its path.
    Raises InputError where the two tables do not have the same scenes in the same order.
    """
    factors = {name: points[name].to_numpy(dtype=float) for name in as_in(FACTOR_COLUMNS, points)}
    if limits is None:
        return Factors.of(**factors)
    place = "limits" if isinstance(limits, pd.DataFrame) else limits
    if not isinstance(limits, pd.DataFrame):
        limits = read_columns(limits, columns=LIMIT_COLUMNS)
    for name, values in factors.items():
        if len(limits) != len(points) or not np.array_equal(limits[name], values):
            raise InputError(
                f"{place}: {name}: not the scenes of the table of forces; make it from the same "
                "table of scenes"
            )
    columns = {name: pd.to_numeric(limits[name], errors="coerce") for name in COLUMNS.values()}
    return Factors.of(**factors, **{name: each.to_numpy() for name, each in columns.items()})


def check_columns(model: ExpressionModel, factors: Factors) -> None:
    """See that a model's columns are known at every point.

    Raises InputError naming the column, and what to do.
    """
    for name in model.column_names:
        unknown = np.flatnonzero(~np.isfinite(factors.column(name)))
        if len(unknown):
            raise InputError(
                f"{name}: unknown at {len(unknown)} of {len(factors)} points, the first in row "
                f"{unknown[0] + 1}: the physics limit does not hold there (see its status), so the "
                f"model {model.name} cannot be used on these points"
            )
