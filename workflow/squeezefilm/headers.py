"""Tables as people and programs write them: a header's words and units, and numbers.

``x_mm``, ``X [mm]``, ``X/mm``, ``x position mm``, ``Phase in Grad``, ``w (um) @ freq=43270``. This
is the only place that takes them apart: what words mean is up to each kind of table. A number has a
decimal point, or a comma where commas do not separate cells.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from squeezefilm.errors import InputError
from squeezefilm.lazy import pd

UNIT_NAMES = {
    name: unit
    for unit, names in {
        "deg": "degree degrees grad degre degres",
        "rad": "radian radians",
        "m": "meter meters metre metres",
        "mm": "millimeter millimeters millimetre millimetres",
        "um": "micron microns micrometer micrometers micrometre micrometres",
    }.items()
    for name in names.split()
}
"""Other names of units, without accents."""
BREAK, BETWEEN_WORDS = re.compile(r"[\s_/,\[(]+"), re.compile(r"[\s_\-.:()\[\]/]+")


def folded(text: str) -> str:
    """A text in small letters without accents, quotes and blanks around it."""
    letters = unicodedata.normalize("NFKD", text.strip("\"' \t").casefold())
    return "".join(each for each in letters if not unicodedata.combining(each))


def unit_in(text: str) -> str:
    """A unit with its brackets taken off, in one spelling: ``(Degrees)`` is ``deg``."""
    unit = re.sub(r"/s(?:ec)?\^?2$", "/s²", folded(text).strip(" []()"))
    unit = re.sub(r"/sec$", "/s", unit)
    return UNIT_NAMES.get(unit, unit)


def words_and_unit(cell: str, units: Collection[str]) -> Iterator[tuple[list[str], str]]:
    """The ways to read a header's cell, the likeliest first: its words, and its unit or ``""``.

    First come known units, then none, then the last word as a unit that is not known.
    """
    name = folded(cell.partition("@")[0])
    ends = [(name[: at.start()], unit_in(name[at.end() :])) for at in BREAK.finditer(name)]
    # Decibels are known, to be named in a message: the file does not tell what 0 dB is.
    known = [end for end in ends if end[1] in units or "db" in end[1]]
    for words, unit in (*known, (name, ""), *ends[-1:]):
        yield [word for word in BETWEEN_WORDS.split(words) if word], unit


BESIDE = {"position", "pos", "coordinate", "coord", "part", "value"}
BESIDE |= {"displacement", "displ", "disp", "velocity", "vel"}
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
        quantities: units with their sizes, ``folded``, and names in small letters, of each.
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
        for words, unit in words_and_unit(name, self._units):
            core = [word for word in words if word not in BESIDE] or words[:1]
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
