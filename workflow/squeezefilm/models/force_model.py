"""The empirical force models: formulas for the mean force, fitted to simulations.

A model is an expression in the factors of an experiment and in parameters theta. Those of the
library (models.yaml) and those that a study adds are alike; the paper's (7) and (14) are two of
the library's.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import product
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError, naming
from squeezefilm.formulas.dimensions import parameter_units
from squeezefilm.formulas.expressions import Expression, Name, Node, Number, parse
from squeezefilm.models.data import COLUMNS, FACTORS, Factors
from squeezefilm.solution import CARTESIAN, POLAR

Array = NDArray[np.float64]

LIBRARY = Path(__file__).with_name("models.yaml")
UNITS_OF_SUFFIX = {"m": "m", "deg": "deg", "n": "N"}
SPACES = ("two_factor", "four_factor")
"""Where models are compared: the finger centred, or anywhere."""
NAMING = ("comparison", "refine")
"""The sections of a study that name models for each space."""
MOST_PARAMETERS = 30
STEP = 1e-30
"""Of the complex step of derivatives, over the parameter's magnitude."""


@dataclass(frozen=True)
class ExpressionModel:
    """One empirical model: its formula, its value and its gradient.

    parameter_names are in the order of theta, parameter_units theirs; about says in words what the
    model is.
    """

    name: str
    expression: str
    parameter_names: tuple[str, ...]
    parameter_units: tuple[str, ...]
    about: str = ""
    place: str = "model"
    """Where the expression was written, for messages."""

    @cached_property
    def parsed(self) -> Expression:
        """The expression, read. Raises InputError where it is refused."""
        names = (*FACTORS, *COLUMNS, *self.parameter_names)
        return parse(self.expression, names=names, place=self.place)

    @property
    def column_names(self) -> tuple[str, ...]:
        """The columns with results of physics that the model needs, besides the factors."""
        return tuple(COLUMNS[name] for name in COLUMNS if name in self.parsed.names)

    @property
    def factor_names(self) -> tuple[str, ...]:
        """The factors the model depends on, in the order of a design's columns.

        A position is always two of them; Cartesian unless the expression is in polar form. Results
        of physics depend on all factors.
        """
        used = {FACTORS[name] for name in FACTORS if name in self.parsed.names}
        if used.intersection((*POLAR, "phi_rad")):
            return ("h0_m", "hv_m", *POLAR)
        if used.intersection(CARTESIAN) or self.column_names:
            return ("h0_m", "hv_m", *CARTESIAN)
        return ("h0_m", "hv_m")

    @property
    def is_centred(self) -> bool:
        """Whether gap and amplitude are its only factors: a model of the centred finger."""
        return self.factor_names == ("h0_m", "hv_m")

    @property
    def is_linear(self) -> bool:
        """Whether the force is a linear function of the parameters, so that no search is needed."""
        return _degree(self.parsed.root, self.parameter_names) <= 1

    def factors(self, points: ArrayLike) -> Factors:
        """Factors from the rows of a design, shape (n, number of factors), in SI units."""
        points = np.asarray(points, dtype=float)
        if points.ndim != 2 or points.shape[1] != len(self.factor_names):
            raise InputError(
                f"a design for the {self.name} model has the columns "
                f"{', '.join(self.factor_names)}; got an array of shape {points.shape}"
            )
        return Factors.of(**dict(zip(self.factor_names, points.T, strict=True)))

    def evaluate(self, theta: ArrayLike, factors: Factors) -> Array:
        """Force eta in newtons, from the model's expression.

        theta has shape (p,) or, for a whole population, (m, p); the result has shape (n,) or
        (m, n). Where the expression is undefined the result is NaN.
        """
        theta = self._checked(theta)
        force_n = np.empty((*theta.shape[:-1], len(factors)))
        force_n[...] = self.parsed.evaluate(**self._inputs(theta, factors))
        force_n[~np.isfinite(force_n)] = np.nan
        return force_n

    def gradient(self, theta: ArrayLike, factors: Factors) -> Array:
        """Derivatives of eta with respect to theta, shape (n, p).

        theta has shape (p,). Where the expression is undefined the row is NaN.
        Raises InputError where the expression has a value and no finite derivative.
        """
        theta = self._checked(theta)
        if theta.ndim != 1:
            raise InputError(f"gradient takes one theta, not a population of {len(theta)}")
        value = self.evaluate(theta, factors)
        step = STEP * np.where(theta == 0, 1.0, np.abs(theta))
        turned = self.parsed.evaluate(**self._inputs(theta + 1j * np.diag(step), factors))
        slopes = np.broadcast_to(turned.imag / step[:, None], (len(theta), len(factors))).T
        defined, known = np.isfinite(value), np.isfinite(slopes)
        if known.all() and defined.all():
            return slopes
        wrong = np.argwhere(defined[:, None] & ~known)
        if len(wrong):
            row, column = wrong[0]
            raise InputError(
                f"{self.place}: {self.expression!r} has no finite derivative with respect to "
                f"{self.parameter_names[column]} {self.described(theta, factors, row)}"
            )
        return np.where(defined[:, None], slopes, np.nan)

    def described(self, theta: ArrayLike, factors: Factors, row: int) -> str:
        """A point and the parameters there in words, for messages."""
        names = (*self.factor_names, *self.column_names)
        point = ", ".join(f"{name} {factors.column(name)[row]:g}" for name in names)
        given = zip(self.parameter_names, np.asarray(theta, dtype=float), strict=True)
        parameters = ", ".join(f"{name} = {value:g}" for name, value in given)
        return f"at {point}" + (f", with {parameters}" if parameters else "")

    def _checked(self, theta: ArrayLike) -> Array:
        theta = np.asarray(theta, dtype=float)
        count = len(self.parameter_names)
        if theta.ndim not in (1, 2) or theta.shape[-1] != count:
            raise InputError(
                f"theta: the {self.name} model has {count} parameters; got shape {theta.shape}"
            )
        return theta

    def _inputs(self, theta: Array, factors: Factors) -> dict[str, Array]:
        parameters = {
            name: theta[..., index, None] for index, name in enumerate(self.parameter_names)
        }
        used = {
            name: factors.column(column)
            for name, column in (FACTORS | COLUMNS).items()
            if name in self.parsed.names
        }
        return parameters | used


def _degree(part: Node, parameters: tuple[str, ...]) -> float:
    """Degree of a formula as a polynomial of the parameters; infinite where it is none."""
    if isinstance(part, Number | Name):
        return float(isinstance(part, Name) and part.name in parameters)
    degrees = [_degree(each, parameters) for each in part.arguments]
    if part.operator in ("+", "-", "negative"):
        return max(degrees)
    if part.operator == "*":
        return sum(degrees)
    constant = not any(degrees[1:] if part.operator == "/" else degrees)
    return degrees[0] if constant else inf


def make_model(name: str, settings: Mapping[str, Any], *, place: str) -> ExpressionModel:
    """A model from its entry in a library.

    ``expression`` is its formula and ``parameters`` lists parameters that are not called t0, t1,
    …, or maps parameters to their units; units that are not given are inferred. ``place`` is where
    the entry stands, for messages.
    Raises InputError naming the place, for an expression that is refused or whose units do not fit.
    """
    declared = settings.get("parameters", {})
    known = (*FACTORS, *COLUMNS)
    for parameter in declared:
        if parameter in known or not re.fullmatch(r"[a-z][a-z0-9_]*", parameter):
            raise InputError(
                f"{place}.parameters: {parameter!r} cannot name a parameter; take letters, digits "
                f"and _, and none of {', '.join(known)}"
            )
    usual = tuple(f"t{index}" for index in range(MOST_PARAMETERS))
    where = f"{place}.expression"
    expression = parse(
        settings["expression"],
        names=(*known, *declared, *usual),
        known=", ".join((*known, *declared, "pi", "and the parameters t0, t1, …")),
        place=where,
    )
    for parameter in declared:
        if parameter not in expression.names:
            raise InputError(f"{place}.parameters: {parameter!r} does not occur in the expression")
    parameters = (
        *declared,
        *(each for each in usual if each in expression.names and each not in declared),
    )
    if len(parameters) > MOST_PARAMETERS:
        raise InputError(
            f"{where}: {len(parameters)} parameters; at most {MOST_PARAMETERS} are allowed"
        )
    units = {key: _unit_of(column) for key, column in (FACTORS | COLUMNS).items()}
    if isinstance(declared, Mapping):
        units |= {key: str(unit) for key, unit in declared.items() if unit is not None}
    inferred = parameter_units(expression, units=units, parameters=parameters, place=where)
    return ExpressionModel(
        name=name,
        expression=expression.text,
        parameter_names=parameters,
        parameter_units=tuple(inferred.values()),
        about=settings.get("about", ""),
        place=where,
    )


def _unit_of(column: str) -> str:
    """A column's unit, which the end of its name tells; 1 for none."""
    return UNITS_OF_SUFFIX.get(column.rsplit("_", 1)[-1], "1")


@cache
def library() -> Mapping[str, ExpressionModel]:
    """The models of models.yaml, by name."""
    entries = yaml.safe_load(LIBRARY.read_text(encoding="utf-8"))
    return {name: make_model(name, entry, place=name) for name, entry in entries.items()}


def get_model(name: str, *, beside: Iterable[str] = ()) -> ExpressionModel:
    """The library's model of that name; raises InputError for an unknown one.

    ``beside`` are names known otherwise, for the message.
    """
    if name not in library():
        known = ", ".join((*beside, *library()))
        raise InputError(f"model {name!r} is unknown; known are {known}")
    return library()[name]


def model_named(name: str, own: Mapping[str, Any], *, place: object) -> ExpressionModel:
    """A model by its name; ``two-factor`` is ``two_factor``.

    ``own`` is the section ``models`` of a study's configuration, ``place`` the file for messages.
    Raises InputError for an unknown name, and where one of the study's own is refused.
    """
    name = name.replace("-", "_")
    if name in own:
        return make_model(name, own[name], place=f"{place}: models.{name}")
    return get_model(name, beside=own)


def check_models(own: Mapping[str, Any], named: Mapping[str, Any], *, place: object) -> None:
    """Read every model of a configuration: its own, and those that ``named`` has by section.

    Raises InputError naming the place of a formula that is refused, of a name that is the
    library's, or of a candidate that is unknown.
    """
    for name in own:
        if name in library():
            raise InputError(
                f"{place}: models.{name}: the library has a model of this name; take another"
            )
        model_named(name, own, place=place)
    for section, space in product(NAMING, SPACES):
        for name in named[section][space]:
            with naming(f"{place}: {section}.{space}"):
                model_named(name, own, place=place)


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


TWO_FACTOR = get_model("two_factor")
FOUR_FACTOR = get_model("four_factor")
