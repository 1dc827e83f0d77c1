"""What the header of a vibrometer's table names: quantities, each with its unit.

``x_mm``, ``X [mm]``, ``X (mm)``, ``X/mm`` and ``x position mm`` are the same column.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from squeezefilm.io.errors import InputError
from squeezefilm.units import sizes

LENGTHS_M = sizes("m")
SPEEDS_M_PER_S = {f"{name}/s": size for name, size in LENGTHS_M.items()}
ANGLES_RAD = {name: math.radians(degrees) for name, degrees in sizes("deg").items()}
MOTIONS = {**LENGTHS_M, **SPEEDS_M_PER_S}
UNITS: Mapping[str, Mapping[str, float]] = {
    "x": LENGTHS_M,
    "y": LENGTHS_M,
    "r": LENGTHS_M,
    "phi": ANGLES_RAD,
    "amplitude": MOTIONS,
    "real": MOTIONS,
    "imaginary": MOTIONS,
    "phase": ANGLES_RAD,
    "sign": {"": 1.0},
}
NAMES = {
    "x": "x",
    "y": "y",
    "r": "r",
    "radius": "r",
    "phi": "phi",
    "theta": "phi",
    "angle": "phi",
    "amplitude": "amplitude",
    "magnitude": "amplitude",
    "amp": "amplitude",
    "mag": "amplitude",
    "displacement": "amplitude",
    "velocity": "amplitude",
    "real": "real",
    "re": "real",
    "imaginary": "imaginary",
    "imag": "imaginary",
    "im": "imaginary",
    "phase": "phase",
    "phase angle": "phase",
    "sign": "sign",
}
# Words beside the one that names the quantity.
BESIDE = {"position", "pos", "coordinate", "coord", "displacement", "velocity", "part", "value"}
PLACES = ({"x", "y"}, {"r", "phi"}, {"r"})
IN_BRACKETS = re.compile(r"(?P<words>.*?)[\s_]*[\[(]\s*(?P<unit>[^\])]*?)\s*[\])]")
DECIBELS = re.compile(r"db\b.*|dB.*", re.IGNORECASE)
FORM = "columns such as x_mm, y_mm, amplitude_um, phase_deg or r_mm, amplitude_um"


@dataclass(frozen=True)
class Column:
    """A quantity of UNITS, the unit it is in ("" if none is named), and its place in a row."""

    quantity: str
    unit: str
    place: int
    name: str

    @property
    def size(self) -> float:
        """Of its unit, in SI units and radians."""
        return UNITS[self.quantity][self.unit]

    @property
    def is_velocity(self) -> bool:
        return self.unit in SPEEDS_M_PER_S


def column_of(name: str, place: int = 0) -> Column | None:
    """The column that a cell of a header names; None for one that a scan does not have."""
    name = name.strip().strip("\"'").strip()
    for words, unit in _splits(name):
        quantity = _quantity(words)
        if quantity is None:
            continue
        known = UNITS[quantity]
        plain = next((each for each in known if each.lower() == unit.lower()), unit)
        return Column(quantity, unit if unit in known else plain, place, name)
    return None


def _splits(name: str) -> list[tuple[str, str]]:
    """Ways to read a name as words and a unit, the likeliest first."""
    found = IN_BRACKETS.fullmatch(name)
    if found:
        return [(found["words"], found["unit"])]
    breaks = [match.start() for match in re.finditer(r"[\s_/,]", name)]
    pairs = [(name[:at], name[at + 1 :].strip()) for at in breaks]
    units = {unit.lower() for known in UNITS.values() for unit in known if unit}
    with_unit = [pair for pair in pairs if pair[1].lower() in units or DECIBELS.fullmatch(pair[1])]
    one_word = [pair for pair in pairs[-1:] if len(breaks) == 1]
    return [*with_unit, (name, ""), *one_word]


def _quantity(words: str) -> str | None:
    parts = [part for part in re.split(r"[\s_\-.:]+", words.lower()) if part]
    core = [part for part in parts if part not in BESIDE] or parts[:1]
    return NAMES.get(" ".join(core))


def columns_of(header: Sequence[str], *, path: Path, line: int) -> tuple[list[Column], list[str]]:
    """The columns that make a scan, and notes on those left out.

    Raises InputError naming the file, the header's line and what is missing or ambiguous.
    """
    where = f"{path}: line {line}"
    found = [column_of(name, place) for place, name in enumerate(header)]
    decibels = [column for column in found if column and DECIBELS.fullmatch(column.unit)]
    columns = [column for column in found if column and column not in decibels]
    unknown = [name.strip() for name, column in zip(header, found, strict=True) if not column]
    quantities = [column.quantity for column in columns]
    if "amplitude" in quantities and "phase" not in quantities and "imaginary" in quantities:
        columns = [column for column in columns if column.quantity != "amplitude"]
    elif "amplitude" in quantities:
        columns = [each for each in columns if each.quantity not in ("real", "imaginary")]
    left_out = [each.name for each in found if each and each not in columns]
    _check(columns, header, where=where, decibels=bool(decibels), unknown=unknown)
    left_out += unknown
    notes = [f"columns left out: {', '.join(map(repr, left_out))}"] if left_out else []
    return columns, notes


def _check(
    columns: Sequence[Column],
    header: Sequence[str],
    *,
    where: str,
    decibels: bool,
    unknown: Sequence[str],
) -> None:
    seen: dict[str, Column] = {}
    for column in columns:
        if column.unit not in UNITS[column.quantity]:
            units = ", ".join(f"{column.quantity}_{unit}" for unit in UNITS[column.quantity])
            raise InputError(f"{where}: column {column.name!r} needs a unit, one of {units}")
        if column.quantity in seen:
            first = seen[column.quantity].name
            raise InputError(
                f"{where}: the column {column.quantity!r} stands twice: {first!r} and "
                f"{column.name!r}; leave one of them out"
            )
        seen[column.quantity] = column
    place = set(seen) & {"x", "y", "r", "phi"}
    if place not in PLACES:
        raise InputError(
            f"{where}: the place of a point is x and y, or r, or r and phi; "
            f"the columns are {', '.join(header)}"
        )
    motion = set(seen) & {"amplitude", "real", "imaginary"}
    if not motion and decibels:
        raise InputError(
            f"{where}: amplitudes in decibels are not taken, for the file does not say what 0 dB "
            "is nor how far down noise reaches; export them on a linear scale (m, µm, mm/s)"
        )
    if not motion:
        other = f"; unknown columns: {', '.join(map(repr, unknown))}" if unknown else ""
        raise InputError(f"{where}: column 'amplitude_um' is missing; a scan has {FORM}{other}")
    if motion in ({"real"}, {"imaginary"}):
        raise InputError(f"{where}: real and imaginary part go together; one of them is missing")
    if "real" in motion and seen["real"].is_velocity != seen["imaginary"].is_velocity:
        raise InputError(f"{where}: real and imaginary part must both be displacements or speeds")
    if {"sign", "phase"} <= set(seen):
        raise InputError(f"{where}: give sign or phase, not both")
