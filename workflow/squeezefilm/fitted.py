"""A fitted model as its file tells it: all that its users need, without the study it came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from squeezefilm.errors import InputError
from squeezefilm.force_model import ExpressionModel, get_model, make_model
from squeezefilm.tables import read_json


@dataclass(frozen=True)
class FittedModel:
    """Parameters (theta4 in 1/m), their number of points, and the residual on those points.

    global_error is |y − η|/|y|, sum_of_squares in N². ranges are the least and the largest value
    of each factor's column that the model was fitted on; cross_validation holds the errors at
    points left out, where there are enough of them. values is the whole file.
    """

    model: str
    theta: tuple[float, ...]
    points: int
    global_error: float
    sum_of_squares: float
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    cross_validation: Mapping[str, float] | None = None
    values: Mapping[str, Any] = field(default_factory=dict, repr=False)
    place: str = "fit"

    @property
    def force_model(self) -> ExpressionModel:
        """The model with the formula that the file carries; the library's, if it carries none.

        Raises:
            InputError: naming the file, for a formula that is refused or an unknown model.
        """
        if "expression" not in self.values:
            return get_model(self.model)
        names, units = (self.values.get(key) for key in ("parameters", "parameter_units"))
        if not (isinstance(names, list) and isinstance(units, list) and len(names) == len(units)):
            raise InputError(
                f"{self.place}: 'parameters' and 'parameter_units' must be lists of one length"
            )
        parameters = dict(zip(map(str, names), map(str, units), strict=True))
        entry = {"expression": self.values["expression"], "parameters": parameters}
        model = make_model(self.model, entry, place=self.place)
        if len(model.parameter_names) != len(self.theta):
            raise InputError(
                f"{self.place}: 'theta' has {len(self.theta)} numbers for the parameters "
                f"{', '.join(model.parameter_names)}"
            )
        return model


def read_fit(path: Path | str) -> FittedModel:
    """Read a fit.

    Raises:
        InputError: naming the file and the entry that is missing or no number.
    """
    values = read_json(path)
    if "refused" in values:
        raise InputError(f"{path}: there is no fit: {values['refused']}")
    try:
        theta = tuple(float(value) for value in values["theta"])
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{path}: 'theta' must be a list of numbers") from None
    crossed = values.get("cross_validation")
    if crossed is not None and not isinstance(crossed, dict):
        raise InputError(f"{path}: 'cross_validation' must be a mapping, or null")
    return FittedModel(
        model=str(values.get("model")),
        theta=theta,
        points=int(number(values, "points", path)),
        global_error=number(values, "global_error", path),
        sum_of_squares=number(values, "sum_of_squares", path),
        ranges=_ranges(values.get("ranges", {}), path),
        cross_validation=crossed and {key: number(crossed, key, path) for key in crossed},
        values=values,
        place=str(path),
    )


def _ranges(values: Any, path: Path | str) -> dict[str, tuple[float, float]]:
    try:
        return {str(name): (float(low), float(high)) for name, (low, high) in values.items()}
    except (AttributeError, TypeError, ValueError):
        raise InputError(f"{path}: 'ranges' must map columns to [least, largest]") from None


def number(values: Mapping[str, Any], key: str, path: Path | str) -> float:
    """A number of a JSON object.

    Raises:
        InputError: naming the file and the key.
    """
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{path}: {key!r} must be a number, not {value!r}")
    return float(value)
