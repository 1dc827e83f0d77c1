"""Columns of tables as people write them: a quantity, its unit behind it, and numbers.

``x_mm``, ``X [mm]``, ``X/mm``, ``x position (mm)`` are one column; a number has a decimal point, or
a comma where commas do not separate cells.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from squeezefilm.errors import InputError
from squeezefilm.lazy import pd

MOTION_NAMES = ("displacement", "disp", "displ", "velocity", "vel")
BESIDE = {"position", "pos", "coordinate", "coord", "part", "value", *MOTION_NAMES}
"""Words beside the one that names a quantity."""


class Column(NamedTuple):
    """A quantity, the unit it is in ("" if none is named), its place in a row, and its name.

    ``size`` is the unit's, in the quantity's own; None of one that the quantity has not.
    """

    quantity: str
    unit: str
    size: float | None
    place: int
    name: str


@dataclass(frozen=True)
class Vocabulary:
    """Quantities that a header may name.

    Attributes:
        quantities: units in small letters with their sizes, and names in small letters, of each.
    """

    quantities: Mapping[str, tuple[Mapping[str, float], tuple[str, ...]]]

    @cached_property
    def _of_names(self) -> dict[str, str]:
        return {name: key for key, (_, names) in self.quantities.items() for name in names}

    @cached_property
    def _units(self) -> set[str]:
        return {unit for units, _ in self.quantities.values() for unit in units if unit}

    def column(self, name: str, place: int = 0) -> Column | None:
        """The column that a cell of a header names; None for one that is not of these."""
        name = name.strip("\"' \t")
        breaks = re.finditer(r"[\s_/,\[(]+", name)
        ends = [(name[: at.start()], name[at.end() :].strip(" ])").lower()) for at in breaks]
        # The likeliest first. Decibels are known, to be named in a message: the file does not tell
        # what 0 dB is.
        known = [each for each in ends if each[1] in self._units or "db" in each[1]]
        for words, unit in (*known, (name, ""), *ends[-1:]):
            parts = [part for part in re.split(r"[\s_\-.:]+", words.lower()) if part]
            core = [part for part in parts if part not in BESIDE] or parts[:1]
            if quantity := self._of_names.get(" ".join(core)):
                return Column(quantity, unit, self.quantities[quantity][0].get(unit), place, name)
        return None


def with_points(cells: pd.Series, *, name: object, place: str = "line") -> pd.Series:
    """Cells of a column with decimal points where they have commas.

    Raises InputError naming the line, in the index, where some have a comma and others a point.
    """
    comma, point = (cells.str.contains(sign, regex=False) for sign in ",.")
    if comma.any() and point.any():
        line, cell = next(cells[point].items())
        raise InputError(
            f"{place} {line}: {name} has a point in {cell!r}, and a comma in other rows; one of "
            "them must be the decimal sign, and nothing stands between thousands"
        )
    return cells.str.replace(",", ".", regex=False)
