"""How closely a number must be met, and the few degrees of closeness that a study has.

They follow from the tolerance that the solver was asked for. On any machine and device a force
lies within it of the truth, so that two machines differ by no more than twice as much. What
follows from forces differs in proportion (docs/numerics.md, "How accurate must a simulation be?").
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

Cells = Mapping[str, str]


@dataclass(frozen=True)
class Worst:
    """The cell that is farthest off, in units of what is allowed there: at most one passes.

    ``shown`` is what is expected and got, where that is not the cell's text.
    """

    cell: str
    distance: float
    shown: tuple[str, str] | None = None


class Tolerance(Protocol):
    """What a quantity's cells are judged by; as text, how close they must be."""

    def worst(self, expected: Cells, got: Cells) -> Worst:
        """The cell that is farthest off; both have the same cells."""
        ...


@dataclass(frozen=True)
class Same:
    """Texts that must be equal."""

    def __str__(self) -> str:
        return "equal"

    def worst(self, expected: Cells, got: Cells) -> Worst:
        """The first cell that differs, or the first of all."""
        for cell, text in expected.items():
            if got[cell] != text:
                return Worst(cell, np.inf)
        return Worst(next(iter(expected)), 0.0)


@dataclass(frozen=True)
class Close:
    """Numbers within a share of each value, of the column's largest magnitude, or an amount."""

    relative: float = 0.0
    of_largest: float = 0.0
    absolute: float = 0.0

    def __str__(self) -> str:
        parts = (
            (self.relative, "of the value"),
            (self.of_largest, "of the column's largest"),
            (self.absolute, "absolute"),
        )
        return " + ".join(f"{size:.2g} {of}" for size, of in parts if size) or "equal"

    def worst(self, expected: Cells, got: Cells) -> Worst:
        """The cell whose difference is the largest share of what is allowed there."""
        cells = list(expected)
        want, have = _numbers(expected, cells), _numbers(got, cells)
        largest = float(np.max(np.abs(want[np.isfinite(want)]), initial=0.0))
        allowed = self.relative * np.abs(want) + self.of_largest * largest + self.absolute
        both_missing = np.isnan(want) & np.isnan(have)
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = np.where(both_missing | (want == have), 0.0, np.abs(have - want) / allowed)
        distance = np.where(np.isnan(distance), np.inf, distance)
        index = int(np.argmax(distance))
        return Worst(cells[index], float(distance[index]))


@dataclass(frozen=True)
class AtMost:
    """Numbers that must not exceed a limit, whatever they were when the reference was made."""

    limit: float

    def __str__(self) -> str:
        return f"at most {self.limit:.3g}"

    def worst(self, expected: Cells, got: Cells) -> Worst:
        """The cell with the largest number."""
        cells = list(expected)
        numbers = _numbers(got, cells)
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = np.where(numbers == 0, 0.0, numbers / self.limit)
        distance = np.where(np.isnan(distance), np.inf, distance)
        index = int(np.argmax(distance))
        return Worst(cells[index], float(distance[index]))


_NUMBER = re.compile(r"[-−]?\d+(?:\.(\d+))?(?:e([-−]?\d+))?")


@dataclass(frozen=True)
class LastDigit:
    """Texts with numbers: the words equal, each number within one unit of its last digit.

    Or a share of its value beyond that, where the digits shown are more than are known.
    """

    relative: float = 0.0

    def __str__(self) -> str:
        return f"one unit of the last digit shown + {self.relative:.2g} of the value"

    def worst(self, expected: Cells, got: Cells) -> Worst:
        """The text with the largest difference, as a share of what is allowed."""
        distances = {cell: self._distance(text, got[cell]) for cell, text in expected.items()}
        cell = max(distances, key=lambda name: distances[name])
        return Worst(cell, distances[cell])

    def _distance(self, expected: str, got: str) -> float:
        if _NUMBER.sub("#", expected) != _NUMBER.sub("#", got):
            return np.inf
        pairs = zip(_NUMBER.finditer(expected), _NUMBER.finditer(got), strict=True)
        return max((self._apart(want, have) for want, have in pairs), default=0.0)

    def _apart(self, expected: re.Match[str], got: re.Match[str]) -> float:
        """In units of the coarser last digit; just over one by rounding counts as one."""
        unit = max(_last_digit(expected), _last_digit(got))
        allowed = unit + self.relative * abs(_plain(expected))
        return round(abs(_plain(expected) - _plain(got)) / allowed, 6)


def _plain(number: re.Match[str]) -> float:
    return float(number.group().replace("−", "-"))


def _last_digit(number: re.Match[str]) -> float:
    decimals, exponent = number.group(1) or "", (number.group(2) or "0").replace("−", "-")
    return float(10.0 ** (int(exponent) - len(decimals)))


SAME = Same()
GIVEN = Close(relative=1e-9, of_largest=1e-12)
"""What the configuration gives, through plain arithmetic."""

DERIVED = Close(of_largest=0.01)
"""What is derived in several steps, and local pressures, which the solver's tolerance is not of."""

PLACE = Close(of_largest=1e-3)
"""Where an optimal point lies: an optimum is flat, so its place is known to the root of its value's
accuracy; a thousandth of the space is far below anything that a design is used for."""


@dataclass(frozen=True)
class Closeness:
    """What a study's solver tolerance (relative) means for the quantities made from forces."""

    solver: float

    @property
    def force(self) -> Close:
        """A simulated force: each of two lies within the tolerance of the truth."""
        return Close(relative=2 * self.solver)

    @property
    def model(self) -> Close:
        """A fitted force: errors of forces pass to it about one to one, also from five points."""
        return Close(of_largest=4 * self.solver + 1e-7)

    @property
    def residual(self) -> Close:
        """A norm of residuals over the norm of the forces: it moves no more than the forces do."""
        return Close(absolute=4 * self.solver + 1e-7)

    @property
    def parameters(self) -> Close:
        """Parameters, loosely: errors of forces reach them sevenfold, and more in combination."""
        return Close(relative=100 * self.solver + 1e-4, of_largest=100 * self.solver + 1e-6)

    @property
    def shown(self) -> LastDigit:
        """A number as a text shows it."""
        return LastDigit(relative=20 * self.solver)

    @property
    def relative_error(self) -> Close:
        """A model's relative error: where the force is small, a small part of the others' errors.

        The smallest forces of a plan are hundreds of times smaller than the largest.
        """
        return Close(of_largest=min(0.05, 1e4 * self.solver))


def _numbers(cells: Cells, names: list[str]) -> np.ndarray:
    return np.array([_number(cells[name]) for name in names])


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return np.nan
