"""Numbers with units, as they are typed on a command line."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from squeezefilm.io.errors import InputError

EXAMPLES = {"deg": "45deg", "N": "0.5N"}
MOST_LEVELS = 10_000


def quantity(text: str, *, option: str, unit: str) -> float:
    """A number with its unit, in the given unit.

    Raises:
        InputError: naming the option, for a text that is no number with such a unit.
    """
    from pint import PintError

    try:
        found: Any = _registry().Quantity(text)
        if not found.dimensionless or unit == "deg":
            value = float(found.to(unit).magnitude)
            if np.isfinite(value):
                return value
    except (PintError, ValueError, TypeError, AttributeError, AssertionError, ArithmeticError):
        pass
    example = EXAMPLES.get(unit, "5um")
    raise InputError(f"{option} {text!r} must be a number with a unit of {unit}, such as {example}")


def quantities(text: str, *, option: str, unit: str) -> list[float]:
    """One number with its unit, several with commas, or evenly spaced ones as first:last:count.

    Raises:
        InputError: naming the option, as quantity does.
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


@cache
def _registry() -> Any:
    from pint import UnitRegistry  # slow to import, and only needed where units are typed

    return UnitRegistry()


def with_error(force_n: float, error_n: float) -> str:
    """A force and its error, both to the digits that the error, with two digits, leaves."""
    if not (math.isfinite(error_n) and error_n > 0):
        return f"{force_n:.9g} N ± {error_n:.1g} N"
    places = min(max(1 - math.floor(math.log10(error_n)), 0), 15)
    return f"{force_n:.{places}f} N ± {error_n:.2g} N"
