"""Results of a scene that was solved, and the columns of tables that hold them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from math import nan
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from squeezefilm.columns import COLUMNS, error_column
from squeezefilm.errors import InputError
from squeezefilm.lazy import pd
from squeezefilm.units import split_unit


@dataclass(kw_only=True, slots=True)  # not frozen, which takes three times as long to make
class Solution:
    """The mean force of one scene and how it was obtained; a scene that was not tried has no more
    than a status and a method.

    Attributes:
        force_n: mean force over a period; NaN unless ``status`` is ``ok``.
        force_error_n: estimate of its absolute error.
        status: ``ok``, or what went wrong.
        validity: ``ok``, or the limits of validity that the scene exceeds (film/validity.py).
        method: name of the method.
        domain: part of the pad that was solved; the rest follows by symmetry.
        absent_terms: names of the terms that the equation did not have.
        nx, ny, nt: collocation points across the pad, or along a radius and around for an
            elliptical one, and over the period.
        newton_steps, krylov_iterations: over all grids.
        residual: estimate of the mass error that Newton's iteration left, relative to p0 h0.
        operation_count: floating-point operations of the iterations, for sharing out run time; no
            column.
        states: the periodic state on the last two grids, the finer one last, where it was asked for
            (reynolds/periodic/launch.PeriodicStates); no column.
        derivatives: of the force, where they were asked for (quantities/derivatives.py).
        outputs: quantities beside the force, where they were requested (quantities/outputs.py).
    """

    force_n: float = nan
    force_error_n: float = nan
    status: str
    validity: str = ""
    method: str
    domain: str = ""
    absent_terms: str = ""
    nx: int = 0
    ny: int = 0
    nt: int = 0
    newton_steps: int = 0
    krylov_iterations: int = 0
    residual: float = 0.0
    operation_count: float = field(default=0.0, metadata={"column": False})
    states: tuple[Any, ...] = field(
        default=(), repr=False, compare=False, metadata={"column": False}
    )
    derivatives: Derivatives | None = field(default=None, metadata={"column": False})
    outputs: Outputs | None = field(default=None, metadata={"column": False})

    @property
    def requested_row(self) -> dict[str, float | str]:
        """A row of what was asked for beside the force."""
        asked = (self.derivatives, self.outputs)
        return {
            name: value
            for quantity in asked
            if quantity
            for name, value in quantity.columns().items()
        }


class Solutions(Sequence[Solution]):
    """Solutions of many scenes as columns: an array of shape (n,) for each attribute of one.

    ``solutions[k]`` is the solution of one scene, ``solutions[rows]`` those of some.
    """

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> np.ndarray: ...

    def __init__(self, columns: Mapping[str, np.ndarray]) -> None:
        self.columns = dict(columns)
        vars(self).update(columns)

    @classmethod
    def unsolved_of_method(cls, method: str, count: int) -> Solutions:
        """Solutions that are not known yet."""
        columns = {}
        for name, value in (DEFAULT_OF_COLUMN | {"method": method}).items():
            # Numbers as such; texts and what has parts as objects.
            kind = type(value) if isinstance(value, (int, float)) else object
            columns[name] = np.empty(count, dtype=kind)
            columns[name].fill(value)
        return cls(columns)

    @classmethod
    def of(cls, solutions: Sequence[Solution]) -> Solutions:
        """The columns of some solutions."""
        if isinstance(solutions, Solutions):
            return solutions
        table = cls.unsolved_of_method("", len(solutions))
        for row, solution in enumerate(solutions):
            for name, column in table.columns.items():
                column[row] = getattr(solution, name)
        return table

    def __len__(self) -> int:
        return len(self.status)

    @overload
    def __getitem__(self, rows: int) -> Solution: ...
    @overload
    def __getitem__(self, rows: slice | np.ndarray) -> Solutions: ...
    def __getitem__(self, rows: int | slice | np.ndarray) -> Solution | Solutions:
        if isinstance(rows, (int, np.integer)):
            return next(iter(self[np.array([rows])]))
        return Solutions({name: column[rows] for name, column in self.columns.items()})

    def __iter__(self) -> Iterator[Solution]:
        columns = [column.tolist() for column in self.columns.values()]
        return (Solution(**dict(zip(DEFAULT_OF_COLUMN, row))) for row in zip(*columns))  # noqa: B905

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and list(self) == list(other)

    def with_replaced_rows(self, rows: np.ndarray, others: Solutions) -> Solutions:
        """The solutions with others in the place of some."""
        columns = {name: column.copy() for name, column in self.columns.items()}
        for name, column in columns.items():
            column[rows] = others.columns[name]
        return Solutions(columns)

    def with_replaced_column(self, name: str, values: Sequence[object]) -> Solutions:
        """The solutions with other values of an attribute."""
        column = np.empty(len(self), dtype=object)
        for row, value in enumerate(values):
            column[row] = value
        return Solutions(self.columns | {name: column})

    def to_frame(self, index: pd.Index | None = None) -> pd.DataFrame:
        """The columns of a table of forces, a row for each scene, and of what was asked for."""
        forces = pd.DataFrame({name: self.columns[name] for name in SOLUTION_COLUMNS}, index=index)
        if not self.have_requested_quantities.any():
            return forces
        asked = pd.DataFrame([solution.requested_row for solution in self], index=forces.index)
        return pd.concat([forces, asked], axis=1)

    @property
    def have_requested_quantities(self) -> np.ndarray:
        """Return which scenes have derivatives or outputs beside the force, (n,)."""
        return self.derivatives.astype(bool) | self.outputs.astype(bool)


# What stands in a column before it is known.
DEFAULT_OF_COLUMN: dict[str, object] = {
    column.name: "" if column.default is MISSING else column.default for column in fields(Solution)
}
SOLUTION_COLUMNS = tuple(
    column.name for column in fields(Solution) if column.metadata.get("column", True)
)

REQUESTABLE_COLUMNS = [column for column in COLUMNS.values() if column.of]
DERIVATIVE_COLUMNS = {
    column.of: column.name for column in REQUESTABLE_COLUMNS if column.name.startswith("dforce_d")
}
"""Numbers that the force may be differentiated to, and the columns of the derivatives."""


@dataclass(frozen=True, kw_only=True)
class Derivatives:
    """Derivatives of a scene's mean force, each to one number with the others kept.

    Those to x and y are along the actuator's axes; that to h0 is the film's static stiffness, with
    the other sign.

    Attributes:
        value: in newtons over the number's unit, by DERIVATIVE_COLUMNS' names; 0 for a number that
            the scene's equation does not have, NaN unless ``status`` is ``ok``.
        error: estimate of its absolute error.
        status: ``ok``, or why there are none.
    """

    value: Mapping[str, float] = field(
        default_factory=lambda: dict.fromkeys(DERIVATIVE_COLUMNS, nan)
    )
    error: Mapping[str, float] = field(
        default_factory=lambda: dict.fromkeys(DERIVATIVE_COLUMNS, nan)
    )
    status: str

    def columns(self) -> dict[str, float | str]:
        """A row of a table of forces: ``dforce_dNAME_UNIT``, ``dforce_dNAME_error_UNIT``."""
        row: dict[str, float | str] = {}
        for number, name in DERIVATIVE_COLUMNS.items():
            row[name] = self.value[number]
            row[error_column(name)] = self.error[number]
        return row | {"derivatives_status": self.status}


# Ends of the interval of the modelling error, over the force.
MODELLING_ERROR_COLUMNS = [f"modelling_error_{end}_percent" for end in ("lower", "upper")]

# What may be asked for beside the mean force: the numbers of each output and their columns.
# docs/outputs.md has their signs and formulas.
OUTPUT_COLUMNS: dict[str, dict[str, str]] = {}
for column in REQUESTABLE_COLUMNS:
    if column.of not in DERIVATIVE_COLUMNS:
        OUTPUT_COLUMNS.setdefault(column.of, {})[split_unit(column.name)[0]] = column.name


def validated_output_names(names: Iterable[str]) -> tuple[str, ...]:
    """The names of outputs in the order of OUTPUT_COLUMNS; ``all`` of them.

    Raises InputError for another name, with those that there are.
    """
    asked = set(names)
    if unknown := asked - {*OUTPUT_COLUMNS, "all"}:
        raise InputError(f"outputs: {min(unknown)!r} is none of {', '.join(OUTPUT_COLUMNS)}")
    return tuple(name for name in OUTPUT_COLUMNS if name in asked or "all" in asked)


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """A scene's quantities beside the mean force.

    Attributes:
        requested_names: the outputs that were asked for, of OUTPUT_COLUMNS.
        value: by the names in OUTPUT_COLUMNS, in the units there; one that is not there is not
            known.
        error: estimate of its absolute error, for each value.
        missing: why an output is not there, or a part of it; by output.
    """

    requested_names: tuple[str, ...] = ()
    value: Mapping[str, float] = field(default_factory=dict)
    error: Mapping[str, float] = field(default_factory=dict)
    missing: Mapping[str, str] = field(default_factory=dict)

    @property
    def status(self) -> str:
        """``ok``, or what is missing and why."""
        return "; ".join(f"{name}: {reason}" for name, reason in self.missing.items()) or "ok"

    @classmethod
    def of(
        cls,
        asked: tuple[str, ...],
        values: Mapping[str, tuple[float, float]],
        missing: Mapping[str, str],
    ) -> Outputs:
        """Return what was asked for of numbers with errors, and of reasons for missing ones."""
        names = [name for output in asked for name in OUTPUT_COLUMNS[output] if name in values]
        return cls(
            requested_names=asked,
            value={name: values[name][0] for name in names},
            error={name: values[name][1] for name in names},
            missing={name: why for name, why in missing.items() if name in asked},
        )

    def columns(self) -> dict[str, float | str]:
        """A row of a table of forces: ``NAME_UNIT``, ``NAME_error_UNIT``, ``outputs_status``."""
        row: dict[str, float | str] = {}
        for output in self.requested_names:
            for quantity, name in OUTPUT_COLUMNS[output].items():
                row[name] = self.value.get(quantity, nan)
                row[error_column(name)] = self.error.get(quantity, nan)
        return row | {"outputs_status": self.status}
