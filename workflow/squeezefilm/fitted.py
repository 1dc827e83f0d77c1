"""A fitted model as its file tells it: what figures, tables and claims need of a fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from squeezefilm.errors import InputError
from squeezefilm.tables import read_json


@dataclass(frozen=True)
class FittedModel:
    """Parameters (theta4 in 1/m), their number of points, and the residual on those points.

    global_error is |y − η|/|y|, sum_of_squares in N².
    """

    model: str
    theta: tuple[float, ...]
    points: int
    global_error: float
    sum_of_squares: float


def read_fit(path: Path | str) -> FittedModel:
    """Read a fit.

    Raises:
        InputError: naming the file and the entry that is missing or no number.
    """
    values = read_json(path)
    try:
        theta = tuple(float(value) for value in values["theta"])
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{path}: 'theta' must be a list of numbers") from None
    return FittedModel(
        model=str(values.get("model")),
        theta=theta,
        points=int(number(values, "points", path)),
        global_error=number(values, "global_error", path),
        sum_of_squares=number(values, "sum_of_squares", path),
    )


def number(values: Mapping[str, Any], key: str, path: Path | str) -> float:
    """A number of a JSON object.

    Raises:
        InputError: naming the file and the key.
    """
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{path}: {key!r} must be a number, not {value!r}")
    return float(value)
