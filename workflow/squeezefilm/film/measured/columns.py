"""The columns of a scan's table: what its header's words mean, in which unit.

The words stand in words.csv, so that a program or a language is lines there: those that name a
quantity together, and those that may stand beside it. Words of a motion alone are its amplitude,
with a direction its part along z, with a quantity (``Velocity Real``) that.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.files import read_text
from squeezefilm.film.measured.scan import nearest_line
from squeezefilm.headers import folded, unit_in, words_and_unit
from squeezefilm.units import unit_sizes

LENGTHS_M = {folded(name): size for name, size in unit_sizes("m").items()}
LENGTHS_M |= {"in": 0.0254, "mil": 25.4e-6}
# Units of motions, and by which power of the angular frequency they are larger than a displacement.
PER_SECOND = {"": 0, "/s": 1, "/s²": 2}
MOTIONS = {name + end: size for end in PER_SECOND for name, size in LENGTHS_M.items()}
ANGLES_RAD = {name: math.radians(degrees) for name, degrees in unit_sizes("deg").items()}
ANGLES_RAD |= {"cycles": 2 * math.pi}
FREQUENCIES_HZ = {name.lower(): size for name, size in unit_sizes("Hz").items()}
PLACES = dict.fromkeys(("x", "y", "r"), LENGTHS_M) | {"phi": ANGLES_RAD}
SHAPES = dict.fromkeys(("amplitude", "real", "imaginary"), MOTIONS) | {"phase": ANGLES_RAD}
UNIT_SIZES = PLACES | SHAPES | {"sign": {"": 1.0}}
"""What a scan is read from, each with its units, in small letters, and their sizes."""
KNOWN = UNIT_SIZES | {"normal": MOTIONS, "frequency": FREQUENCIES_HZ, "time": unit_sizes("s")}
"""The same, with the amplitude along z and what rows of a place may differ by."""
UNITS = {*MOTIONS, *ANGLES_RAD, *FREQUENCIES_HZ, "s"}
USUAL_UNITS = dict.fromkeys(("x", "y", "r"), "mm") | {"phi": "deg", "phase": "deg", "sign": "1"}
USUAL_UNITS |= dict.fromkeys(("amplitude", "real", "imaginary"), "um")
AT_FREQUENCY = re.compile(r"@.*freq[^=]*=\s*([\d.eE+]+)\s*(\w*)")
"""How a program writes the frequency at which a column was solved."""

_ROWS = csv.reader(
    read_text(Path(__file__).with_name("words.csv"), what="list of words").splitlines()[1:]
)
WORDS = {meaning: words.split(";") for meaning, words in _ROWS}
NAMES = {
    frozenset(words.split()): quantity for quantity in KNOWN for words in WORDS.get(quantity, ())
}
MOTION, COMPONENT = {*WORDS["motion"], *WORDS["normal"]}, {*WORDS["component"]}
DIRECTION, IGNORED_WORDS = {*WORDS["direction"]}, {*WORDS["beside"]}
# The amplitude of a harmonic motion over its effective value and its extent from peak to peak.
AMPLITUDE_RATIOS = {"rms": math.sqrt(2), "span": 0.5}
RATIOS = [
    (words.split(), ratio) for kind, ratio in AMPLITUDE_RATIOS.items() for words in WORDS[kind]
]


@dataclass(frozen=True)
class Column:
    """A quantity, the unit it is in ("" if none is named), its place in a row, and its name.

    ``size`` is the unit's in SI units and radians; None of one that the quantity has not.
    ``ratio`` is the amplitude over what the column has: √2 for effective values.
    """

    quantity: str
    unit: str
    size: float | None
    place: int
    name: str
    ratio: float = 1.0

    @property
    def power(self) -> int:
        """The power of the angular frequency by which a motion in the unit is too large."""
        return PER_SECOND[re.sub(r"^[^/]*", "", self.unit)]

    @property
    def frequency_hz(self) -> float | None:
        """The frequency that the name says, if any: ``w (um) @ freq=43270``."""
        if match := AT_FREQUENCY.search(self.name):
            return float(match[1]) * FREQUENCIES_HZ.get(match[2].lower(), 1.0)
        return None


def meaning(words: Sequence[str]) -> str | None:
    """The quantity that words name; None for one that a scan does not have."""
    core = {*words} - IGNORED_WORDS or {*words[:1]}
    if quantity := NAMES.get(frozenset(words)) or NAMES.get(frozenset(core)):
        return quantity
    if quantity := NAMES.get(frozenset(core - COMPONENT)):
        return quantity
    rest = frozenset(core - MOTION - COMPONENT)
    if rest == core or not (rest or core & MOTION):
        return None
    if rest and rest <= DIRECTION:
        return "normal"
    quantity = NAMES.get(rest) if rest else "amplitude"
    return quantity if quantity in SHAPES else None


def column_of(name: str, place: int = 0) -> Column | None:
    """The column that a cell of a header names; None for one that a scan does not have."""
    for words, unit in words_and_unit(name, UNITS):
        words, ratio = _without_ratio(words)
        if quantity := meaning(words):
            return Column(quantity, unit, KNOWN[quantity].get(unit), place, name, ratio)
    return None


def _without_ratio(words: list[str]) -> tuple[list[str], float]:
    """Words of an amplitude in place of those of RATIOS, and its ratio to what they name."""
    for named, ratio in RATIOS:
        for at in range(len(words)):
            if words[at : at + len(named)] == named:
                return [*words[:at], *words[at + len(named) :], "amplitude"], ratio
    return words, 1.0


def named_columns(header: Sequence[str]) -> list[Column]:
    """The columns that a header names."""
    return [column for at, name in enumerate(header) if (column := column_of(name, at))]


def chosen_columns(
    header: Sequence[str], wanted: Collection[str], *, frequency_hz: float | None
) -> tuple[dict[str, Column], list[str]]:
    """The columns of some quantities, by these, and notes on the choice.

    Of several parts of a motion that along z is taken, of several frequencies the actuator's.

    Raises:
        InputError: for a quantity that stands twice.
    """
    named = named_columns(header)
    usable = {column.quantity for column in named if column.size}
    if "imaginary" in usable and "phase" not in usable:
        wanted = {*wanted} - {"amplitude"}
    other = "normal" if "amplitude" in usable and "normal" not in usable else "amplitude"
    if "normal" in {column.quantity for column in named}:
        named = [column for column in named if column.quantity != other]
    named = [
        replace(column, quantity="amplitude") if column.quantity == "normal" else column
        for column in named
    ]
    if "amplitude" in wanted and {"amplitude", "normal"} & usable:
        wanted = {*wanted} - {"real", "imaginary"}
    named = [column for column in named if column.quantity in wanted]
    named, notes = _at_frequency(named, frequency_hz)
    columns: dict[str, Column] = {}
    for column in sorted(named, key=lambda each: each.size is None):
        first = columns.setdefault(column.quantity, column)
        if column.size and first is not column:
            raise InputError(
                f"the column {column.quantity!r} stands twice: {first.name!r} and "
                f"{column.name!r}; leave one of them out"
            )
    return columns, notes


def check_units(columns: Collection[Column]) -> None:
    """Reject columns without a unit that is known, all at once."""
    lacking = [column for column in columns if not column.size]
    names = ", ".join(repr(each.name) for each in lacking)
    written = ", ".join(f"{each.name} [{USUAL_UNITS[each.quantity]}]" for each in lacking)
    if any("db" in each.unit for each in lacking):
        raise InputError(f"decibels are not supported; export {names} on a linear scale")
    if lacking:
        raise InputError(
            f"no unit is known of {names}; write it into the header, as in {written}. "
            f"Lengths are in {', '.join(LENGTHS_M)}, motions also over s or s², angles in "
            f"{', '.join(ANGLES_RAD)}"
        )


def _at_frequency(
    named: list[Column], frequency_hz: float | None
) -> tuple[list[Column], list[str]]:
    """The columns at the actuator's frequency, and all that have none, and a note."""
    lines_hz = np.array([each.frequency_hz for each in named if each.frequency_hz is not None])
    if len(set(lines_hz)) < 2:
        return named, []
    if frequency_hz is None:
        raise InputError("columns at several frequencies need the actuator's frequency")
    line_hz, far = nearest_line(lines_hz, frequency_hz)
    if far:
        raise InputError(f"the columns' frequencies: {far}")
    kept = [each for each in named if each.frequency_hz in (None, line_hz)]
    return kept, [f"columns at {line_hz:.7g} Hz"]


def with_units(header: Sequence[str], cells: Sequence[str]) -> list[str]:
    """A header with the units of the line below it; itself if that line has no units alone."""
    units = list(map(unit_in, cells))
    if not {*units} & UNITS or not {*units} <= {*UNITS, "", "-"} or len(cells) > len(header):
        return list(header)
    units += [""] * (len(header) - len(units))
    return [
        f"{name} [{unit}]" * bool(unit) or name for name, unit in zip(header, units, strict=True)
    ]
