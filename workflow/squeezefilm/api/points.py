"""The points that are asked for: every combination of some values of each factor."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from itertools import product
from math import prod
from typing import TypedDict

import numpy as np
import pandas as pd

from squeezefilm.errors import InputError
from squeezefilm.solution import CARTESIAN, POLAR
from squeezefilm.units import quantities

Values = str | float | Sequence[float] | np.ndarray
"""Values of one factor: a number in SI units (degrees for angles), several of them, or a text with
units such as ``"5 um"``, ``"5 um, 6 um"``, ``"0.5:2.5:9 um"`` (first:last:count)."""
COLUMNS = {"h0": "h0_m", "hv": "hv_m", "x": "x_m", "y": "y_m", "phi_r": "phi_r_m", "phi": "phi_deg"}
"""What the factors are called where they are asked for, and their columns."""
MOST_POINTS = 1_000_000
WIDTH = 80


class Position(TypedDict, total=False):
    """The finger's centre from the actuator's: Cartesian, or polar with phi in degrees."""

    x: Values | None
    y: Values | None
    phi_r: Values | None
    phi: Values | None


class Points(pd.DataFrame):
    """A table with a row for each point, as pandas has it, which shows what it holds.

    All columns, and 2.2e-06 for what pandas shows as 0.000002 where no other format is set.
    """

    @property
    def _constructor(self) -> type[Points]:
        return Points

    def __repr__(self) -> str:
        with _shown_whole():
            return str(super().__repr__())

    def _repr_html_(self) -> str | None:
        with _shown_whole():
            html: str | None = super()._repr_html_()  # type: ignore[misc]
            return html


def _shown_whole() -> AbstractContextManager[None]:
    number = pd.get_option("display.float_format") or "{:.6g}".format
    whole = ("display.width", WIDTH, "display.max_columns", None)
    return pd.option_context(*whole, "display.float_format", number)


def points_of(
    *,
    h0: Values | None = None,
    hv: Values | None = None,
    x: Values | None = None,
    y: Values | None = None,
    phi_r: Values | None = None,
    phi: Values | None = None,
    option: str = "{}",
) -> Points:
    """Every combination of the values given, a column for each factor given.

    What is added to it, such as forces, is a table of Points again.

    Args:
        option: how a factor's name is written in messages.

    Raises InputError for a value without its unit or no finite number, for a position in both
    forms, for too many points.
    """
    given = {"h0": h0, "hv": hv, "x": x, "y": y, "phi_r": phi_r, "phi": phi}
    called = {name: option.format(name.replace("_", "-")) for name in given}
    levels = {
        COLUMNS[name]: _levels(values, called=called[name], unit="deg" if name == "phi" else "m")
        for name, values in given.items()
        if values is not None
    }
    if levels.keys() & {*CARTESIAN} and levels.keys() & {*POLAR}:
        message = "give the position as {x} and {y} or as {phi_r} and {phi}, not both"
        raise InputError(message.format(**called))
    if "phi_deg" in levels and "phi_r_m" not in levels:
        message = "{phi} is a direction; give the distance from the centre by {phi_r} too"
        raise InputError(message.format(**called))
    if (count := prod(map(len, levels.values()))) > MOST_POINTS:
        raise InputError(f"these make {count} points; at most {MOST_POINTS} are allowed")
    return Points(list(product(*levels.values())), columns=list(levels), dtype=float)


def _levels(values: Values, *, called: str, unit: str) -> list[float]:
    if isinstance(values, str):
        return quantities(values, option=called, unit=unit)
    try:
        numbers = np.atleast_1d(np.asarray(values, dtype=float)).ravel()
    except (TypeError, ValueError):
        numbers = np.array([np.nan])
    if not len(numbers) or not np.isfinite(numbers).all():
        raise InputError(
            f"{called}: {values!r} is no finite number in {unit}, nor several of them, nor a text "
            "with units"
        )
    return [float(value) for value in numbers]
