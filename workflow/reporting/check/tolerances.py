"""How closely a quantity must be met.

The degrees of closeness follow from the tolerance that the solver was asked for. On any machine and
device a force lies within it of the truth, so that two machines differ by no more than twice as
much. What follows from forces differs in proportion (docs/numerics.md, "How accurate must a
simulation be?").
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from squeezefilm.designs.paper_design import d_efficiency
from squeezefilm.errors import InputError
from squeezefilm.models.force_model import get_model

Cells = Mapping[str, str]
_NUMBER = re.compile(r"[-−]?\d+(?:\.(\d+))?(?:e([-−+]?\d+))?")


@dataclass(frozen=True)
class Worst:
    """The cell that is farthest off, in units of what is allowed there: at most one passes.

    ``got`` is shown where that is not the cell's text.
    """

    cell: str
    distance: float
    got: str | None = None


class Tolerance(Protocol):
    """What a quantity's cells are judged by; as text, how close they must be."""

    def worst(self, expected: Cells, got: Cells) -> Worst:
        """The cell that is farthest off; both have the same cells."""
        ...


@dataclass(frozen=True)
class Close:
    """Texts of equal words, and numbers in them within the sum of what is given.

    Attributes:
        relative: a share of each value.
        of_largest: a share of the largest magnitude in the column.
        absolute: an amount.
        digits: units of the last digit that is shown.
    """

    relative: float = 0.0
    of_largest: float = 0.0
    absolute: float = 0.0
    digits: float = 0.0

    def __str__(self) -> str:
        parts = {
            "of the value": self.relative,
            "of the column's largest": self.of_largest,
            "absolute": self.absolute,
            "of the last digit shown": self.digits,
        }
        return " + ".join(f"{size:.2g} {of}" for of, size in parts.items() if size) or "equal"

    def worst(self, expected: Cells, got: Cells) -> Worst:
        """The cell whose difference is the largest share of what is allowed there."""
        sizes = [abs(_value(text)) for text in expected.values()]
        largest = max((size for size in sizes if math.isfinite(size)), default=0.0)
        distances = {
            cell: self._distance(text, got[cell], self.of_largest * largest)
            for cell, text in expected.items()
        }
        cell = max(distances, key=lambda name: distances[name])
        return Worst(cell, distances[cell])

    def _distance(self, expected: str, got: str, allowed: float) -> float:
        if expected == got:
            return 0.0
        if _NUMBER.sub("#", expected) != _NUMBER.sub("#", got):
            return math.inf
        pairs = zip(_NUMBER.finditer(expected), _NUMBER.finditer(got), strict=True)
        return max(self._apart(want, have, allowed + self.absolute) for want, have in pairs)

    def _apart(self, expected: re.Match[str], got: re.Match[str], allowed: float) -> float:
        """In units of what is allowed; just over one by rounding counts as one."""
        want, have = _value(expected.group()), _value(got.group())
        unit = max(_last_digit(expected), _last_digit(got))
        allowed += self.relative * abs(want) + self.digits * unit
        if want == have:
            return 0.0
        return round(abs(want - have) / allowed, 6) if allowed else math.inf


def _value(text: str) -> float:
    try:
        return float(text.replace("−", "-"))
    except ValueError:
        return math.nan


def _last_digit(number: re.Match[str]) -> float:
    decimals, exponent = number.group(1) or "", (number.group(2) or "0").replace("−", "-")
    return float(10.0 ** (int(exponent) - len(decimals)))


@dataclass(frozen=True)
class AtMost:
    """Numbers that must not exceed a limit, whatever they were when the reference was made."""

    limit: float

    def __str__(self) -> str:
        return f"at most {self.limit:.3g}"

    def worst(self, expected: Cells, got: Cells) -> Worst:
        """The cell with the largest number."""
        distances = {cell: self._distance(_value(text)) for cell, text in got.items()}
        cell = max(distances, key=lambda name: distances[name])
        return Worst(cell, distances[cell])

    def _distance(self, number: float) -> float:
        if math.isnan(number) or (number > 0 and not self.limit):
            return math.inf
        return number / self.limit if number else 0.0


@dataclass(frozen=True)
class Efficient:
    """Designs that teach as much: D-efficiency beside the reference's, in the reference's model.

    Cells are the parameters (``theta0``) and the points (``point 1 h0_m``).
    """

    model: str
    loss: float = 1e-3

    def __str__(self) -> str:
        return f"D-efficiency at least {1 - self.loss:g} of the reference's"

    def worst(self, expected: Cells, got: Cells) -> Worst:
        """The loss of efficiency; a gain is none."""
        model = get_model(self.model)
        try:
            theta = [float(expected[name]) for name in model.parameter_names]
            slopes = [
                model.gradient(theta, model.factors(_points(cells, model.factor_names)))
                for cells in (got, expected)
            ]
            efficiency = d_efficiency(*slopes)
        except (InputError, ValueError) as error:
            return Worst("D-efficiency", math.inf, str(error))
        lost = max(0.0, 1 - efficiency) / self.loss
        return Worst("D-efficiency", lost, f"{efficiency:.6f} of the reference's")


def _points(cells: Cells, factors: tuple[str, ...]) -> np.ndarray:
    numbers = sorted({int(name.split()[1]) for name in cells if name.startswith("point ")})
    return np.array(
        [[float(cells[f"point {number} {factor}"]) for factor in factors] for number in numbers]
    )


SAME = Close()
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
    def shown(self) -> Close:
        """A number as a text shows it: where the digits shown are more than are known, those."""
        return Close(relative=20 * self.solver, digits=1)

    @property
    def relative_error(self) -> Close:
        """A model's relative error: where the force is small, a small part of the others' errors.

        The smallest forces of a plan are hundreds of times smaller than the largest.
        """
        return Close(of_largest=min(0.05, 1e4 * self.solver))
