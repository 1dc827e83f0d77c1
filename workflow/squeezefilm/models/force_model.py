"""The empirical force models: formulas for the mean force, fitted to simulations.

A model is an expression in the factors of an experiment and in parameters theta. Those of the
library (models.yaml) and those that a study adds are alike; the paper's (7) and (14) are two of
the library's.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from math import inf
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import yaml
from numpy.typing import ArrayLike

from squeezefilm.config.study import OwnModel, Study
from squeezefilm.errors import InputError, prefix_errors
from squeezefilm.film.positions import CARTESIAN_COLUMNS, POLAR_COLUMNS
from squeezefilm.formulas import (
    Expression,
    Operation,
    fold_formula,
    parameter_units,
    parse_constants,
    parse_formula,
)
from squeezefilm.models.data import (
    FACTOR_COLUMN_OF_NAME,
    PHYSICS_COLUMN_OF_NAME,
    POSITION_COLUMNS,
    Array,
    Factors,
)

LIBRARY_FILE = Path(__file__).with_name("models.yaml")
UNIT_OF_COLUMN_SUFFIX = {"m": "m", "deg": "deg", "n": "N"}
FACTOR_SPACE_NAMES = ("two_factor", "four_factor")
"""Where models are compared: the pad centred, or anywhere."""
MAX_PARAMETERS = 30
COMPLEX_STEP = 1e-30
"""Of the complex step of derivatives, over the parameter's magnitude."""
REAL_DIFFERENCE_STEP = 1e-6
"""Relative change of a parameter over which a force that overflows inside does not change."""


@dataclass(frozen=True)
class ExpressionModel:
    """One empirical model: its formula, its value and its gradient.

    parameter_names are in the order of theta, parameter_units theirs; about says in words what the
    model is.
    """

    name: str
    parsed_expression: Expression
    parameter_names: tuple[str, ...]
    parameter_units: tuple[str, ...]
    about: str = ""
    constants: Mapping[str, str | float] = field(default_factory=dict, hash=False)
    source_location: str = "model"
    """Where the expression was written, for messages."""

    @property
    def expression(self) -> str:
        """The formula's text."""
        return self.parsed_expression.text

    @property
    def formula_text(self) -> str:
        """The formula with its constants, for people."""
        constants = [f"{name} = {value}" for name, value in self.constants.items()]
        return "; ".join([self.expression, *constants])

    @cached_property
    def column_names(self) -> tuple[str, ...]:
        """The columns with results of physics that the model needs, besides the factors."""
        return tuple(
            PHYSICS_COLUMN_OF_NAME[name]
            for name in PHYSICS_COLUMN_OF_NAME
            if name in self.parsed_expression.names
        )

    @cached_property
    def factor_names(self) -> tuple[str, ...]:
        """The factors the model depends on, in the order of a design's columns.

        A position is always two of them; Cartesian unless the expression is in polar form. Results
        of physics depend on all factors.
        """
        used = {
            FACTOR_COLUMN_OF_NAME[name]
            for name in FACTOR_COLUMN_OF_NAME
            if name in self.parsed_expression.names
        }
        polar = used & {*POLAR_COLUMNS, "phi_rad"}
        cartesian = used & set(CARTESIAN_COLUMNS) or self.column_names
        return (
            "h0_m",
            "hv_m",
            *(POLAR_COLUMNS if polar else CARTESIAN_COLUMNS if cartesian else ()),
        )

    @property
    def is_for_centred_pad(self) -> bool:
        """True if gap and amplitude are the only factors: a model of the centred pad."""
        return self.factor_names == ("h0_m", "hv_m")

    @cached_property
    def linear_parameter_names(self) -> tuple[str, ...]:
        """Parameters in which the force is linear, all the others fixed."""
        names: tuple[str, ...] = ()
        for name in self.parameter_names:
            if _degree_in_parameters(self.parsed_expression, (*names, name)) <= 1:
                names = (*names, name)
        return names

    @property
    def is_linear(self) -> bool:
        """True if the force is linear in the parameters, so that no search is needed."""
        return self.linear_parameter_names == self.parameter_names

    def evaluate(self, theta: ArrayLike, factors: Factors) -> Array:
        """Force eta in newtons, from the model's expression.

        theta has shape (p,) or, for a whole population, (m, p); the result has shape (n,) or
        (m, n). Where the expression is undefined the result is NaN.
        """
        theta = np.asarray(theta, dtype=float)
        force_n = np.empty((*theta.shape[:-1], len(factors)))
        force_n[...] = self.parsed_expression.evaluate(**self._expression_inputs(theta, factors))
        force_n[~np.isfinite(force_n)] = np.nan
        return force_n

    def gradient(self, theta: ArrayLike, factors: Factors) -> Array:
        """Derivatives of eta with respect to theta, shape (n, p).

        theta has shape (p,). Where the expression is undefined the row is NaN.
        Raises InputError where the expression has a value and no finite derivative.
        """
        theta = np.asarray(theta, dtype=float)
        value = self.evaluate(theta, factors)
        step = COMPLEX_STEP * np.where(theta == 0, 1.0, np.abs(theta))
        turned = self.parsed_expression.evaluate(
            **self._expression_inputs(theta + 1j * np.diag(step), factors)
        )
        slopes = np.broadcast_to(turned.imag / step[:, None], (len(theta), len(factors))).T
        if not np.all(np.isfinite(slopes)):
            # A part that overflows has no derivative, where the force has one: 1/(1 + exp(1000)).
            change = np.diag(REAL_DIFFERENCE_STEP / COMPLEX_STEP * step)
            ahead, behind = (self.evaluate(theta + way * change, factors).T for way in (1, -1))
            flat = (ahead == value[:, None]) & (behind == value[:, None])
            slopes = np.where(flat & ~np.isfinite(slopes), 0.0, slopes)
        defined, known = np.isfinite(value), np.isfinite(slopes)
        wrong = np.argwhere(defined[:, None] & ~known)
        if len(wrong):
            row, column = wrong[0]
            raise InputError(
                f"{self.source_location}: {self.expression!r} has no finite derivative with "
                f"respect to {self.parameter_names[column]} {self.point_text(theta, factors, row)}"
            )
        return np.where(defined[:, None], slopes, np.nan)

    def point_text(self, theta: ArrayLike, factors: Factors, row: int) -> str:
        """A point and the parameters there in words, for messages."""
        names = (*self.factor_names, *self.column_names)
        point = ", ".join(f"{name} {factors.column(name)[row]:g}" for name in names)
        given = zip(self.parameter_names, np.asarray(theta, dtype=float), strict=True)
        parameters = ", ".join(f"{name} = {value:g}" for name, value in given)
        return f"at {point}" + (f", with {parameters}" if parameters else "")

    def _expression_inputs(self, theta: Array, factors: Factors) -> dict[str, Array]:
        parameters = np.moveaxis(theta, -1, 0)[..., None]
        return dict(zip(self.parameter_names, parameters, strict=True)) | self.formula_values(
            factors
        )

    def formula_values(self, factors: Factors) -> dict[str, Array]:
        """Values of the points by their names in the expression."""
        return {
            name: factors.column(column)
            for name, column in (FACTOR_COLUMN_OF_NAME | PHYSICS_COLUMN_OF_NAME).items()
            if name in self.parsed_expression.names
        }


def _degree_in_parameters(expression: Expression, parameters: tuple[str, ...]) -> float:
    """Degree of a formula as a polynomial of the parameters; infinite where it is none."""

    def degree_of_operation(part: Operation, degrees: list[float]) -> float:
        if part.operator in ("+", "-", "negative"):
            return max(degrees)
        if part.operator == "*":
            return sum(degrees)
        constant = not any(degrees[1:] if part.operator == "/" else degrees)
        return degrees[0] if constant else inf

    return fold_formula(
        expression.root, lambda leaf: float(leaf in parameters), degree_of_operation
    )


def make_model(name: str, settings: Mapping[str, Any], *, source: str) -> ExpressionModel:
    """A model from its entry in a library.

    ``expression`` is its formula and ``parameters`` lists parameters that are not called t0, t1,
    …, or maps parameters to their units; units that are not given are inferred. ``constants`` are
    numbers with units by their names. ``source`` is where the entry stands, for messages.
    Raises InputError naming the place, for an invalid expression or one whose units do not fit.
    """
    declared = settings.get("parameters", {})
    known = (*FACTOR_COLUMN_OF_NAME, *PHYSICS_COLUMN_OF_NAME)
    for parameter in declared:
        if parameter in known or not re.fullmatch(r"[a-z][a-z0-9_]*", parameter):
            raise InputError(
                f"{source}.parameters: {parameter!r} cannot name a parameter; take letters, digits "
                f"and _, and none of {', '.join(known)}"
            )
    usual = tuple(f"t{index}" for index in range(MAX_PARAMETERS))
    given = settings.get("constants", {})
    constants = parse_constants(given, names=(*known, *declared, *usual), source=source)
    where = f"{source}.expression"
    expression = parse_formula(
        settings["expression"],
        names=(*known, *declared, *usual),
        known=", ".join((*known, *declared, "pi", "and the parameters t0, t1, …")),
        source=where,
        constants=constants,
    )
    for parameter in declared:
        if parameter not in expression.names:
            raise InputError(f"{source}.parameters: {parameter!r} does not occur in the expression")
    parameters = tuple(
        dict.fromkeys((*declared, *(symbol for symbol in usual if symbol in expression.names)))
    )
    units = {
        name: UNIT_OF_COLUMN_SUFFIX.get(column.rsplit("_", 1)[-1], "1")
        for name, column in (FACTOR_COLUMN_OF_NAME | PHYSICS_COLUMN_OF_NAME).items()
    }
    if isinstance(declared, Mapping):
        units |= {key: str(unit) for key, unit in declared.items() if unit is not None}
    inferred = parameter_units(expression, units=units, parameters=parameters, source=where)
    return ExpressionModel(
        name=name,
        parsed_expression=expression,
        parameter_names=parameters,
        parameter_units=tuple(inferred.values()),
        about=settings.get("about", ""),
        constants=given,
        source_location=where,
    )


@cache
def library_models() -> Mapping[str, ExpressionModel]:
    """The models of models.yaml, by name."""
    entries = yaml.safe_load(LIBRARY_FILE.read_text(encoding="utf-8"))
    return {name: make_model(name, entry, source=name) for name, entry in entries.items()}


def get_model(
    name: str, own: Mapping[str, OwnModel] = MappingProxyType({}), *, source: object = ""
) -> ExpressionModel:
    """A model of the library or of a study by its name; ``two-factor`` is ``two_factor``.

    ``own`` is the section ``models`` of a study's configuration, ``source`` the file for messages.
    Raises InputError for an unknown name, and where one of the study's own is invalid.
    """
    name = name.replace("-", "_")
    if name in own:
        entry = own[name].model_dump(exclude_none=True)
        return make_model(name, entry, source=f"{source}: models.{name}")
    if name not in library_models():
        raise InputError(
            f"model {name!r} is unknown; known are {', '.join((*own, *library_models()))}"
        )
    return library_models()[name]


def check_models_of_study(study: Study) -> None:
    """Read every model of a study: its own, and those that are compared and refined.

    Raises InputError naming the place of an invalid formula, of a name that is the
    library's, or of a candidate that is unknown.
    """
    own, path = study.models, study.path
    for name in own:
        if name in library_models():
            raise InputError(
                f"{path}: models.{name}: the library has a model of this name; take another"
            )
        get_model(name, own, source=path)
    for section, named in (("comparison", study.comparison), ("refine", study.refine)):
        for space in FACTOR_SPACE_NAMES:
            for name in named.names_of_space(space):
                with prefix_errors(f"{path}: {section}.{space}"):
                    get_model(name, own, source=path)


def model_notes(study: Study) -> Iterator[str]:
    """Yield notes on models that no run would fit, and on those fitted to the centred pad alone
    whose formula has the pad's position."""
    named = {name for section in (study.comparison, study.refine) for name in section.all_names}
    for name in study.models:
        if name not in named:
            yield f"models.{name} is not fitted: add it to a comparison"
    for section, names in (("comparison", study.comparison), ("refine", study.refine)):
        for name in names.names_of_space("two_factor"):
            formula = get_model(name, study.models, source=study.path).parsed_expression
            if any(FACTOR_COLUMN_OF_NAME.get(each) in POSITION_COLUMNS for each in formula.names):
                yield (
                    f"{section}.two_factor: {name} has the pad's position, which is 0 at all these "
                    f"points: name it in {section}.four_factor"
                )


def check_columns_known(model: ExpressionModel, factors: Factors) -> None:
    """Check that a model's columns are known at every point.

    Raises InputError naming the column, the first point where it is not, and the reason.
    """
    for name in model.column_names:
        unknown = np.flatnonzero(~np.isfinite(factors.column(name)))
        if len(unknown):
            first = unknown[0]
            reason = "ok" if factors.statuses is None else factors.statuses[first]
            if reason == "ok":  # that of a force
                reason = "the asymptotic expansion does not hold there"
            raise InputError(
                f"{name}: unknown at {len(unknown)} of {len(factors)} points, the first in row "
                f"{first + 1}: {reason}; the model {model.name} cannot be used on these points"
            )
