"""A fitted model as its file tells it: all that its users need, without the study it came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.film.finger import Finger, GapShape
from squeezefilm.film.profiles import Piston
from squeezefilm.film.scene import Actuator, Gas, Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.film.symmetry import Symmetry, symmetry_from_dict
from squeezefilm.film.validity import validity
from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import POLAR
from squeezefilm.io.tables import read_json
from squeezefilm.models.force_model import ExpressionModel, Factors, get_model, make_model
from squeezefilm.models.limit_table import LimitTable
from squeezefilm.models.prediction_interval import PredictionInterval, measured_interval

Array = NDArray[np.float64]

FILM_UNKNOWN = "not known: the fit's file does not describe its film"
NO_SAMPLE = "the fit has no validation sample (`squeezefilm fit --sample`)"
TABLE_SHARE = 0.1
"""Largest error of a table of asymptotic forces over that of a model that uses it."""


@dataclass(frozen=True)
class FittedModel:
    """Parameters (theta4 in 1/m), their number of points, and the residual on those points.

    global_error is |y − η|/|y|, sum_of_squares in N². ranges are the least and the largest value
    of each factor's column that the model was fitted on; cross_validation holds the errors at
    points left out, where there are enough of them; interval is what a validation sample says of
    its errors, if the file has one. values is the whole file.
    """

    model: str
    theta: tuple[float, ...]
    points: int
    global_error: float
    sum_of_squares: float
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    cross_validation: Mapping[str, float] | None = None
    interval: PredictionInterval | None = None
    values: Mapping[str, Any] = field(default_factory=dict, repr=False)
    place: str = "fit"

    @cached_property
    def force_model(self) -> ExpressionModel:
        """The model with the formula that the file carries; the library's, if it carries none.

        Raises InputError naming the file, for a formula that is refused or an unknown model.
        """
        model = get_model(self.model) if "expression" not in self.values else self._own_model()
        if len(model.parameter_names) != len(self.theta):
            raise InputError(
                f"{self.place}: 'theta' has {len(self.theta)} numbers for the parameters "
                f"{', '.join(model.parameter_names)}"
            )
        return model

    def _own_model(self) -> ExpressionModel:
        names, units = (self.values.get(key) for key in ("parameters", "parameter_units"))
        if not (isinstance(names, list) and isinstance(units, list) and len(names) == len(units)):
            raise InputError(
                f"{self.place}: 'parameters' and 'parameter_units' must be lists of one length"
            )
        parameters = dict(zip(map(str, names), map(str, units), strict=True))
        entry = {"expression": self.values["expression"], "parameters": parameters}
        return make_model(self.model, entry, place=self.place)

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

    def validity(self, factors: Factors) -> list[str]:
        """``ok``, or the limits of validity that each point's film exceeds; FILM_UNKNOWN.

        As if the profile's maximum lay under the whole pad.
        Raises InputError naming the file, for a film that is none.
        """
        if "film" not in self.values:
            return [FILM_UNKNOWN] * len(factors)
        try:
            film = self.values["film"]
            pad = {**film["finger"], "gap": GapShape(**film["finger"]["gap"])}
            alike = Scene(
                *("", 0.0, 0.0, 0.0, 0.0),
                gas=Gas(**film["gas"]),
                actuator=Actuator(film["frequency_hz"], Disc(1.0), Piston()),
                finger=Finger(**pad, speed_x_m_per_s=0.0),
            )
        except (KeyError, TypeError) as error:
            raise InputError(f"{self.place}: 'film' does not describe a film: {error}") from None
        return [
            validity(replace(alike, h0_m=gap, hv_m=amplitude))
            for gap, amplitude in zip(factors.h0_m.tolist(), factors.hv_m.tolist(), strict=True)
        ]

    def validation(self, factors: Factors, force_n: ArrayLike) -> tuple[Array, Array, list[str]]:
        """Errors that hold 95 % and 99 % of new points, and why a point is not validated.

        Args:
            force_n: the model's forces at the points, shape (n,).

        Returns both half widths in newtons, shape (n,), NaN where there is none, and notes that
        are empty where there is.
        """
        force = np.asarray(force_n, dtype=float)
        if self.interval is None:
            unknown = np.full(len(force), np.nan)
            return unknown, unknown, [f"not validated: {NO_SAMPLE}"] * len(force)
        notes = self.interval.outside(factors)
        if self.interval.error_95 is None:
            notes = [note or "too few points of the sample have a force" for note in notes]
        undefined = np.where(np.isfinite(force), "", "undefined here")
        reasons = [
            "; ".join(filter(None, each)) for each in zip(notes, undefined.tolist(), strict=True)
        ]
        notes = [reason and f"not validated: {reason}" for reason in reasons]
        validated = np.array([not note for note in notes], dtype=bool)
        error_95, error_99 = (
            np.where(validated, self.interval.error_n(force, level=level), np.nan)
            for level in (0.95, 0.99)
        )
        return error_95, error_99, notes

    @property
    def statement(self) -> str:
        """What is known of the model's error, in a sentence."""
        return f"Not validated: {NO_SAMPLE}." if self.interval is None else self.interval.statement

    def validated(
        self,
        factors: Factors,
        *,
        force_n: ArrayLike,
        force_error_n: ArrayLike,
        ranges: Mapping[str, tuple[float, float]],
    ) -> FittedModel:
        """The same fit with the prediction interval that a validation sample gives.

        Args:
            factors: points of the sample, with the columns that the model needs where they come
                from physics itself; the file's own table of them is checked against these.
            force_n, force_error_n: simulated, shape (n,); NaN where there is no force.
            ranges: of the declared space from which the points were drawn.

        Raises InputError where the table errs by more than a tenth of the model.
        """
        model, force = self.force_model, np.asarray(force_n, dtype=float)
        model_n = model.evaluate(self.theta, factors)
        if model.column_names and "limit_table" in self.values:
            exact_n, model_n = (
                model_n,
                model.evaluate(self.theta, self.limit_table.complete(factors)),
            )
            known = np.isfinite(exact_n) & np.isfinite(model_n) & np.isfinite(force)
            own, table = (
                float(np.sqrt(np.mean((exact_n - other)[known] ** 2))) if known.any() else np.nan
                for other in (force, model_n)
            )
            if table > TABLE_SHARE * own:
                raise InputError(
                    f"the table of asymptotic forces is too coarse for the study's space: it errs "
                    f"by {table:.2g} N (root mean square over the validation sample) and the model "
                    f"{self.model} by {own:.2g} N; a tenth of that is allowed"
                )
        interval = measured_interval(
            factors,
            model_n=model_n,
            force_n=force,
            force_error_n=force_error_n,
            scale=self.values["error_scale"],
            ranges=ranges,
            profile_uncertainty=self.profile_uncertainty,
        )
        values = {**self.values, "validation": interval.to_dict()}
        return replace(self, interval=interval, values=values)

    @property
    def profile_uncertainty(self) -> float:
        """Largest share of a force that the scan of the study's profile leaves open, at 95 %."""
        return float(self.values.get("profile_uncertainty", 0.0))

    @property
    def profile_uncertainty_percent(self) -> dict[str, float]:
        """A column of the profile's uncertainty in per cent of the force; none without a scan."""
        share = self.profile_uncertainty
        return {"profile_uncertainty_percent": 100 * share} if share else {}


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
        interval=PredictionInterval.from_dict(values["validation"], place=f"{place}: validation")
        if "validation" in values
        else None,
        cross_validation=crossed and {key: number(crossed, key, place) for key in crossed},
        values=values,
        place=str(place),
    )


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
