"""A fitted model as its file tells it: all that its users need, without the study it came from."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from squeezefilm.film.directions import Symmetry, symmetry_from_dict
from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import POLAR
from squeezefilm.io.tables import read_json, read_ok_forces
from squeezefilm.models.experiments import factors_of
from squeezefilm.models.force_model import ExpressionModel, Factors, get_model, make_model
from squeezefilm.models.limit_table import LimitTable
from squeezefilm.models.trust import Trust, Unseen, Verdict


@dataclass(frozen=True)
class FittedModel:
    """Parameters (theta4 in 1/m), their number of points, and the residual on those points.

    global_error is |y − η|/|y|, sum_of_squares in N². ranges are the least and the largest value
    of each factor's column that the model was fitted on; cross_validation holds the errors at
    points left out, where there are enough of them; trust is the evidence of the fit, if the file
    has it. values is the whole file.
    """

    model: str
    theta: tuple[float, ...]
    points: int
    global_error: float
    sum_of_squares: float
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    cross_validation: Mapping[str, float] | None = None
    trust: Trust | None = None
    values: Mapping[str, Any] = field(default_factory=dict, repr=False)
    place: str = "fit"

    @cached_property
    def force_model(self) -> ExpressionModel:
        """The model with the formula that the file carries; the library's, if it carries none.

        Raises InputError naming the file, for a formula that is refused or an unknown model.
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

    @cached_property
    def symmetry(self) -> Symmetry | None:
        """The finger's positions that represent all in the model's study, if the file tells."""
        if "directions" not in self.values:
            return None
        return symmetry_from_dict(self.values["directions"], place=f"{self.place}: directions")

    @property
    def position(self) -> tuple[str, str]:
        """The form of positions in the model's study; polar, if the file does not tell."""
        return POLAR if self.symmetry is None else self.symmetry.position

    def represented(self, factors: Factors) -> Factors:
        """The factors of the same forces with the finger in positions that the model knows.

        By the symmetry of the study's scenes; a file that tells none leaves them as they are.
        """
        if self.symmetry is None:
            return factors
        place = {name: factors.column(name) for name in self.symmetry.position}
        return Factors.of(
            h0_m=factors.h0_m,
            hv_m=factors.hv_m,
            **self.symmetry.represent(**place),
            **factors.columns,
        )

    def complete(self, factors: Factors) -> Factors:
        """The factors with the physics limits that the model needs, from the file's own table.

        Raises InputError naming the file, where it has no such table.
        """
        model = self.force_model
        if all(name in factors.columns for name in model.column_names):
            return factors
        if "limit_table" not in self.values:
            raise InputError(
                f"{self.place}: the model {self.model} needs {', '.join(model.column_names)} and "
                "its file has no table of them; fit it with --limit-table, or give points with "
                "these columns (`squeezefilm limits`)"
            )
        return self.limit_table.complete(factors)

    @cached_property
    def limit_table(self) -> LimitTable:
        """The limits that the file carries."""
        return LimitTable.from_dict(self.values["limit_table"], place=f"{self.place}: limit_table")

    def judge(self, factors: Factors, force_n: ArrayLike) -> Verdict:
        """How far the model's forces at points, in newtons, are to be trusted, and why not."""
        if self.trust is not None:
            return self.trust.judge(factors, force_n)
        unknown = np.full(len(factors), np.nan)
        reason = "the fit's file does not tell its points (`squeezefilm fit` makes it anew)"
        return Verdict(unknown, unknown, (reason,) * len(factors))

    def judged_by(
        self, factors: Factors, *, force_n: ArrayLike, force_error_n: ArrayLike
    ) -> FittedModel:
        """The same fit, judged by simulated forces, in newtons, of which it saw none or some."""
        if self.trust is None:
            return self
        predicted = self.force_model.evaluate(self.theta, self.complete(factors))
        control = Unseen.of(
            factors, model_n=predicted, force_n=force_n, force_error_n=force_error_n
        )
        return replace(self, trust=self.trust.with_control(control))

    @property
    def scan_error(self) -> float:
        """Largest share of a force that the scan of the study's profile leaves open."""
        return self.trust.scan_error if self.trust is not None else 0.0

    @property
    def scan_percent(self) -> dict[str, float]:
        """A column of what the scan leaves open, in per cent of the force; none without a scan."""
        return {"scan_percent": 100 * self.scan_error} if self.scan_error else {}

    @property
    def error_n(self) -> float:
        """The force's error to expect, in newtons: root mean square at points left out of the fit.

        NaN where the file tells none: as many points as parameters leave none to judge by.
        """
        crossed = self.cross_validation or {}
        return float(crossed.get("root_mean_square_n", np.nan))


def read_fit(path: Path | str) -> FittedModel:
    """Read a fit.

    Raises InputError naming the file and the entry that is missing or no number.
    """
    return fit_of(read_json(path), place=path)


def fit_of(values: Mapping[str, Any], *, place: Path | str) -> FittedModel:
    """A fit from what its file holds; ``place`` is the file, for messages.

    Raises InputError naming the place and the entry that is missing or no number.
    """
    if "refused" in values:
        raise InputError(f"{place}: there is no fit: {values['refused']}")
    try:
        theta = tuple(float(value) for value in values["theta"])
    except (KeyError, TypeError, ValueError):
        raise InputError(f"{place}: 'theta' must be a list of numbers") from None
    crossed = values.get("cross_validation")
    if crossed is not None and not isinstance(crossed, dict):
        raise InputError(f"{place}: 'cross_validation' must be a mapping, or null")
    return FittedModel(
        model=str(values.get("model")),
        theta=theta,
        points=int(number(values, "points", place)),
        global_error=number(values, "global_error", place),
        sum_of_squares=number(values, "sum_of_squares", place),
        ranges=_ranges(values.get("ranges", {}), place),
        trust=_trust(values, place),
        cross_validation=crossed and {key: number(crossed, key, place) for key in crossed},
        values=values,
        place=str(place),
    )


def read_judged_fit(path: Path | str, *, control: Sequence[str] | None) -> FittedModel:
    """Read a fit, judged by the simulations of the tables in ``control`` that it never saw.

    Raises InputError naming the file, for one that cannot be read or a point that has no force.
    """
    fit = read_fit(path)
    if not control:
        return fit
    forces = pd.concat([read_ok_forces(each) for each in control], ignore_index=True)
    return fit.judged_by(
        factors_of(forces), force_n=forces["force_n"], force_error_n=forces["force_error_n"]
    )


def expected_error(fit: FittedModel, validation: str | None) -> float:
    """The error to expect in newtons: a validation's root mean square, else the fit's own."""
    if validation is None:
        return fit.error_n
    values = read_json(validation)
    points = number(values, "points", validation)
    squares = number(values, "sum_of_squares", validation)
    if points < 1 or squares < 0:
        raise InputError(f"{validation}: not the summary of a validation")
    return math.sqrt(squares / points)


def _trust(values: Mapping[str, Any], path: Path | str) -> Trust | None:
    return Trust.from_dict(values["trust"], place=f"{path}: trust") if "trust" in values else None


def _ranges(values: Any, path: Path | str) -> dict[str, tuple[float, float]]:
    try:
        return {str(name): (float(low), float(high)) for name, (low, high) in values.items()}
    except (AttributeError, TypeError, ValueError):
        raise InputError(f"{path}: 'ranges' must map columns to [least, largest]") from None


def number(values: Mapping[str, Any], key: str, path: Path | str) -> float:
    """A number of a JSON object.

    Raises InputError naming the file and the key.
    """
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{path}: {key!r} must be a number, not {value!r}")
    return float(value)
