"""Units as they are typed: on a command line, in a column's name, for a formula's parameters."""

import math
import re
from dataclasses import dataclass

import numpy as np

from squeezefilm.io.errors import InputError

BASES = ("N", "m", "s", "deg")
"""A degree counts as a base: a formula that takes degrees for radians is wrong."""
EXAMPLES = {"deg": "45deg", "N": "0.5N"}
MOST_LEVELS = 10_000
MOST_PLACES = 15
"""Decimals of a force that is shown; a smaller one has an exponent."""
QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s]+)\s*", re.ASCII)


@dataclass(frozen=True)
class Unit:
    """Its size in BASES, and the exponents of these."""

    size: float
    exponents: tuple[int, int, int, int]


UNITS = {
    "N": Unit(1.0, (1, 0, 0, 0)),
    "mN": Unit(1e-3, (1, 0, 0, 0)),
    "m": Unit(1.0, (0, 1, 0, 0)),
    "mm": Unit(1e-3, (0, 1, 0, 0)),
    "um": Unit(1e-6, (0, 1, 0, 0)),
    "µm": Unit(1e-6, (0, 1, 0, 0)),
    "μm": Unit(1e-6, (0, 1, 0, 0)),
    "nm": Unit(1e-9, (0, 1, 0, 0)),
    "s": Unit(1.0, (0, 0, 1, 0)),
    "deg": Unit(1.0, (0, 0, 0, 1)),
    "°": Unit(1.0, (0, 0, 0, 1)),
    "rad": Unit(180 / math.pi, (0, 0, 0, 1)),
    "Pa": Unit(1.0, (1, -2, 0, 0)),
    "Hz": Unit(1.0, (0, 0, -1, 0)),
    "kg": Unit(1.0, (1, -1, 2, 0)),
}


def sizes(base: str) -> dict[str, float]:
    """The units that measure what one of BASES does, each with its size in it."""
    exponents = UNITS[base].exponents
    return {name: unit.size for name, unit in UNITS.items() if unit.exponents == exponents}


def quantity(text: str, *, option: str, unit: str) -> float:
    """A number with its unit, in the given one of BASES.

    Raises InputError naming the option, for a text that is no number with such a unit.
    """
    known, match = sizes(unit), QUANTITY.fullmatch(text)
    if match and match[2] in known and math.isfinite(value := float(match[1]) * known[match[2]]):
        return value
    raise InputError(
        f"{option} {text!r} must be a number with a unit of {unit} ({', '.join(known)}), such as "
        f"{EXAMPLES.get(unit, '5um')}"
    )


def quantities(text: str, *, option: str, unit: str) -> list[float]:
    """One number with its unit, several with commas, or evenly spaced ones as first:last:count.

    Raises InputError naming the option, as quantity does.
    """
    parts = text.split(":")
    if len(parts) == 1:
        return [quantity(each, option=option, unit=unit) for each in text.split(",")]
    if len(parts) != 3 or not parts[2].strip().isdecimal() or len(parts[2]) > 12:
        raise InputError(f"{option} {text!r}: a range is first:last:count, such as 5um:10um:6")
    count = int(parts[2])
    if not 2 <= count <= MOST_LEVELS:
        raise InputError(f"{option} {text!r}: the count must lie within 2 … {MOST_LEVELS}")
    first, last = (quantity(each, option=option, unit=unit) for each in parts[:2])
    return [float(f"{value:.12g}") for value in np.linspace(first, last, count)]


def with_error(force_n: float, error_n: float) -> str:
    """A force and its error, both to the digits that the error, with two digits, leaves."""
    if not (math.isfinite(error_n) and error_n > 0):
        return f"{force_n:.9g} N ± {error_n:.1g} N"
    places = max(1 - math.floor(math.log10(error_n)), 0)
    if places > MOST_PLACES:  # a film that bears next to nothing
        return f"{force_n:.2g} N ± {error_n:.2g} N"
    return f"{force_n:.{places}f} N ± {error_n:.2g} N"


def to_its_digits(value: float, error: float) -> str:
    """A value of any size and its error, both to the digits that the error, with two, leaves."""
    if not (math.isfinite(error) and error > 0):
        return f"{value:.9g} ± {error:.1g}"
    size = math.floor(math.log10(abs(value))) if value else -math.inf
    digits = max(size - math.floor(math.log10(error)) + 2, 1)
    return f"{value:.{digits}g} ± {error:.2g}"
