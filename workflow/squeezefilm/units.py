"""Units as they are typed: on a command line, in a column's name, for a formula's parameters."""

import math
import re
from typing import NamedTuple

from squeezefilm.io.errors import InputError

BASES = ("N", "m", "s", "deg")
"""A degree counts as a base: a formula that takes degrees for radians is wrong."""
EXAMPLES = {"deg": "45deg", "N": "0.5N", "Hz": "300Hz", "kg": "50g"}
MOST_LEVELS = 10_000
MOST_PLACES, LEAST_PLAIN = 15, 1e-4
"""Decimals of a value that is shown, and the least that is shown without an exponent."""
DECIMAL = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
QUANTITY = re.compile(rf"\s*({DECIMAL})\s*([^\d\s]+)\s*", re.ASCII)
NUMBER = re.compile(rf"\s*{DECIMAL}\s*", re.ASCII)
OCTAL = re.compile(r"\s*[-+]?0\d")
SHARED_UNIT = re.compile(r"([-+\d.eE,:\s]*[\d.])\s*([^\d\s.,:]+)\s*")
"""Numbers without units, and the unit at the end that is that of all."""
PRODUCT = re.compile(
    r"(?P<sign>[/*·\s]*)(?P<name>[^\d\s/*·^²³]+|1)(?:(?:\^|\*\*)?(?P<power>[1-4²³]))?"
)
POWERS = {"²": 2, "³": 3}
PREFIXES = {
    "": 1.0,
    "p": 1e-12,
    "n": 1e-9,
    "µ": 1e-6,
    "μ": 1e-6,
    "u": 1e-6,
    "m": 1e-3,
    "c": 1e-2,
    "h": 1e2,
    "k": 1e3,
    "M": 1e6,
}


class Unit(NamedTuple):
    """Its size in BASES, and the exponents of these."""

    size: float
    exponents: tuple[int, int, int, int]


UNITS = {
    prefix + name: Unit(PREFIXES[prefix] * size, exponents)
    for name, size, exponents, prefixes in (
        ("N", 1.0, (1, 0, 0, 0), ("", "m")),
        ("m", 1.0, (0, 1, 0, 0), ("", "m", "u", "µ", "μ", "n", "c", "p")),
        ("s", 1.0, (0, 0, 1, 0), ("", "m")),
        ("deg", 1.0, (0, 0, 0, 1), ("",)),
        ("°", 1.0, (0, 0, 0, 1), ("",)),
        ("rad", 180 / math.pi, (0, 0, 0, 1), ("",)),
        ("Pa", 1.0, (1, -2, 0, 0), ("", "µ", "u", "m", "h", "k", "M")),
        ("bar", 1e5, (1, -2, 0, 0), ("",)),
        ("Hz", 1.0, (0, 0, -1, 0), ("", "k", "M")),
        ("g", 1e-3, (1, -1, 2, 0), ("k", "")),
    )
    for prefix in prefixes
}


def sizes(base: str) -> dict[str, float]:
    """The units that measure what one of BASES does, each with its size in it."""
    exponents = UNITS[base].exponents
    return {name: unit.size for name, unit in UNITS.items() if unit.exponents == exponents}


def compound(text: str) -> Unit | None:
    """A unit made of others, such as ``kg/m³``, ``Pa s`` or ``1/mm``; None for anything else."""
    size, exponents, end = 1.0, (0, 0, 0, 0), 0
    for match in PRODUCT.finditer(text.strip()):
        unit = Unit(1.0, (0, 0, 0, 0)) if match["name"] == "1" else UNITS.get(match["name"])
        sign = match["sign"].strip()
        if match.start() != end or unit is None or sign not in ("", "/", "*", "·"):
            return None
        power = POWERS.get(match["power"] or "1") or int(match["power"] or 1)
        power = -power if sign == "/" else power
        size *= unit.size**power
        first, second, third, fourth = unit.exponents
        a, b, c, d = exponents
        exponents = (a + power * first, b + power * second, c + power * third, d + power * fourth)
        end = match.end()
    return Unit(size, exponents) if end == len(text.strip()) and end else None


def in_unit(text: str, unit: str) -> float | None:
    """The number of a text such as ``43.27 kHz`` in another unit; None if it has no such unit.

    A number alone is in that unit already.
    """
    match = NUMBER.match(text)
    if not match or OCTAL.match(text):
        return None
    own, wanted = compound(text[match.end() :] or unit), compound(unit)
    if not own or not wanted or own.exponents != wanted.exponents:
        return None
    # Fifteen digits: 2.2 µm is 2.2e-6 m and not 2.1999999999999997e-6 m.
    value = float(f"{float(match[0]) * own.size / wanted.size:.15g}")
    return value if math.isfinite(value) else None


def examples(unit: str) -> str:
    """Two ways to write a quantity with its unit."""
    wanted = compound(unit)
    known = [name for name, each in UNITS.items() if wanted and each.exponents == wanted.exponents]
    return " or ".join(f"1 {name}" for name in (known or [unit])[:2])


def quantity(text: str, *, option: str, unit: str) -> float:
    """A number with its unit, in the given one of BASES.

    Raises InputError naming the option, for a text that is no number with such a unit.
    """
    known, match = sizes(unit), QUANTITY.fullmatch(text)
    if match and match[2] in known and math.isfinite(value := float(match[1]) * known[match[2]]):
        return float(f"{value:.15g}")  # 5um is 5e-06, not 4.9999999999999996e-06
    raise InputError(
        f"{option} {text!r} must be a number with a unit of {unit} ({', '.join(known)}), such as "
        f"{EXAMPLES.get(unit, '5um')}"
    )


def quantities(text: str, *, option: str, unit: str) -> list[float]:
    """One number with its unit, several with commas, or evenly spaced ones as first:last:count.

    Each number has its unit, or one stands at the end for all: ``0.5,1,2um``, ``0.5:2.5:9um``.
    Raises InputError naming the option, as quantity does.
    """
    *numbers, end = text.split(":")
    if not numbers and "," not in text:
        return [quantity(text, option=option, unit=unit)]
    shared = SHARED_UNIT.fullmatch(text)
    unit_of_all = shared[2] if shared else ""
    if not numbers:
        parts = (shared[1] if shared else text).split(",")
        return [quantity(f"{each}{unit_of_all}", option=option, unit=unit) for each in parts]
    count = end.strip().removesuffix(unit_of_all).strip()
    if len(numbers) != 2 or not count.isdecimal() or len(count) > 12:
        raise InputError(f"{option} {text!r}: a range is first:last:count, such as 5:10:6um")
    if not 2 <= int(count) <= MOST_LEVELS:
        raise InputError(f"{option} {text!r}: the count must lie within 2 … {MOST_LEVELS}")
    first, last = (quantity(f"{each}{unit_of_all}", option=option, unit=unit) for each in numbers)
    step = (last - first) / (int(count) - 1)
    return [float(f"{first + step * number:.12g}") for number in range(int(count))]


def with_error(force_n: float, error_n: float) -> str:
    """A force and its error, both to the first digit of the error."""
    force, error = to_its_error(force_n, error_n)
    return f"{force} N ± {error} N"


def to_its_error(value: float, error: float) -> tuple[str, str]:
    """A value with the digits that its error leaves it, and the error.

    Three digits where the error is not known.
    """
    if error == 0:
        return f"{value:g}", "0"
    if not math.isfinite(error):
        return f"{value:.3g}", "unknown"
    error = abs(error)
    shown = f"{error:.1g}"
    places = -math.floor(math.log10(float(shown)))
    if 0 <= places <= MOST_PLACES and abs(value) >= LEAST_PLAIN:
        return f"{value:.{places}f}", shown
    # A film that bears next to nothing, or an error above 10: as many digits as that makes.
    digits = math.floor(math.log10(abs(value))) + places if value else 0
    return f"{value:.{max(digits, 0)}e}", shown
