"""A fitted model: its forces, the amplitude for a wanted force, its file and its code."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Unpack

import numpy as np
import pandas as pd

from squeezefilm.api.points import COLUMNS as FACTOR_COLUMNS
from squeezefilm.api.points import Position, Values, points_of
from squeezefilm.errors import InputError, naming
from squeezefilm.models.amplitude_for_force import working_point
from squeezefilm.models.data import COLUMNS, Factors
from squeezefilm.models.export import source
from squeezefilm.models.fit_file import FittedModel, read_fit
from squeezefilm.solution import CARTESIAN, POLAR
from squeezefilm.tables import write_json
from squeezefilm.units import quantity

GAPS = 6
"""Evenly spaced over the range of the fit, where a working point's gap is not said."""


@dataclass(frozen=True)
class Fit:
    """A force model with its parameters and the prediction interval of a validation sample.

    Attributes:
        model: all that its file tells.
    """

    model: FittedModel

    @classmethod
    def read(cls, path: Path | str) -> Fit:
        """The fit in a file that ``squeezefilm fit`` or ``save`` wrote.

        Raises InputError naming the file, for one that cannot be read or is none.
        """
        return cls(read_fit(path))

    @property
    def statement(self) -> str:
        """What is known of the model's error, in a sentence."""
        return self.model.statement

    @property
    def name(self) -> str:
        """The model's name."""
        return self.model.model

    @property
    def theta(self) -> dict[str, float]:
        """The parameters by name, in the units of ``model.force_model.parameter_units``."""
        return dict(zip(self.model.force_model.parameter_names, self.model.theta, strict=True))

    def predict(self, h0: Values, hv: Values, **position: Unpack[Position]) -> pd.DataFrame:
        """The model's forces at every combination of gaps, amplitudes and positions.

        The columns are those of ``predict_at``.
        Raises InputError as ``Film.curve`` does.
        """
        return self.predict_at(points_of(h0=h0, hv=hv, **position))

    def predict_at(self, points: pd.DataFrame, *, place: object = "predict") -> pd.DataFrame:
        """The model's forces at a table of points: h0_m, hv_m and a position, if any.

        ``error_95_n`` and ``error_99_n`` are the half widths of the prediction interval
        (``statement`` says what it is); empty where a point is not validated, and ``note`` says
        why. ``validity`` is ``ok``, or the limits of validity of the film equation that the point's
        film exceeds.
        Raises InputError naming the place, for values without physical meaning.
        """
        fit = self.model
        factors = fit.represented(factors_of_points(points, place=place))
        force_n = fit.evaluate(factors)
        error_95_n, error_99_n, notes = fit.validation(factors, force_n)
        with np.errstate(divide="ignore", invalid="ignore"):
            percent = 100 * error_95_n / np.abs(force_n)
        return points.assign(
            force_n=force_n,
            error_95_n=error_95_n,
            error_99_n=error_99_n,
            error_95_percent=percent,
            **fit.profile_uncertainty_percent,
            validity=fit.validity(factors),
            note=notes,
        )

    def working_point(
        self,
        force: str | float,
        h0: Values | None = None,
        **position: Unpack[Position],
    ) -> pd.DataFrame:
        """The smallest amplitude that gives a force, a row for each gap and position.

        Args:
            force: wanted, in newtons or with its unit.
            h0: gaps; evenly spaced over the range of the fit if left out.

        ``hv_error_95_m`` is the 95 % error of the force over its slope, ``error_95_percent`` that
        of the force; empty where the point is not validated, and ``note`` says why.
        Raises InputError as ``predict`` does.
        """
        points = points_of(h0=self.gaps() if h0 is None else h0, **position)
        return self.working_points_at(points, force_n=newtons(force))

    def working_points_at(
        self, points: pd.DataFrame, *, force_n: float, place: object = "working-point"
    ) -> pd.DataFrame:
        """The same for a table of points: h0_m and a position, if any."""
        factors = factors_of_points(points.assign(hv_m=0.0), place=place)
        rows = [
            working_point(self.model, factors.take([index]), force_n=force_n)
            for index in range(len(factors))
        ]
        return pd.concat([points, pd.DataFrame(rows)], axis=1)

    def gaps(self) -> list[float]:
        """A few gaps in metres, evenly spaced over those of the fit.

        Raises InputError where the fit tells none.
        """
        ranges = self.model.ranges
        if "h0_m" not in ranges:
            raise InputError(f"{self.model.place}: tells no range of gaps; give them")
        low, high = ranges["h0_m"]
        gaps = np.linspace(low, high, GAPS if high > low else 1)
        return [float(f"{gap:.12g}") for gap in gaps]

    def code(self, language: str) -> str:
        """The model as code without dependencies, in ``c``, ``python`` or ``javascript``.

        Raises InputError for a model of physics whose file has no table of it.
        """
        return source(self.model, language)

    def save(self, path: Path | str) -> None:
        """Write the fit's file, which ``Fit.read`` and the command line read."""
        write_json(self.model.to_dict(), path)

    def __str__(self) -> str:
        fit = self.model
        units = fit.force_model.parameter_units
        theta = ", ".join(
            f"{name} = {value:.6g}" + (f" {unit}" if unit != "1" else "")
            for (name, value), unit in zip(self.theta.items(), units, strict=True)
        )
        return (
            f"{fit.model}: {fit.force_model.expression}\n{theta or 'no parameters'}\n"
            f"fitted to {fit.points} points, global error {100 * fit.global_error:.2g} %\n"
            f"{fit.statement}"
        )

    __repr__ = __str__


def newtons(force: str | float, *, option: str = "force") -> float:
    """A wanted force; a plain number is in newtons.

    Raises InputError for one without meaning.
    """
    try:
        value = float(force)
    except ValueError:
        return quantity(str(force), option=option, unit="N")
    if not np.isfinite(value):
        raise InputError(f"{option} {force!r} must be a finite force, such as 1.0N")
    return value


def factors_of_points(points: pd.DataFrame, *, place: object) -> Factors:
    """The factors of a table of points, with the results of physics that it has.

    Raises InputError naming the place, for values without physical meaning.
    """
    known = (*FACTOR_COLUMNS.values(), *COLUMNS.values())
    names = [name for name in known if name in points]
    if any(name in names for name in POLAR):  # a table may have both; one says it all
        names = [name for name in names if name not in CARTESIAN]
    with naming(place):
        return Factors.of(**{name: points[name].to_numpy(dtype=float) for name in names})
