"""Units of numbers that people write, such as ``43.27 kHz``.

A dimension maps bases to exponents. A degree counts as a base: a formula that takes degrees for
radians is wrong.
"""

import math
import re
from collections.abc import Mapping
from fractions import Fraction
from typing import NamedTuple

from squeezefilm.errors import InputError

Dimension = Mapping[str, Fraction]
BASE_UNITS = ("N", "m", "s", "deg", "K")
DIMENSIONLESS: Dimension = {}
MAX_SPACED_VALUES = 10_000
MAX_DECIMALS, MIN_VALUE_WITHOUT_EXPONENT = 15, 1e-4
"""Decimals of a value that is shown, and the least that is shown without an exponent."""
DECIMAL_REGEX = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
# 010 is none: it may be an octal 8.
NUMBER_PATTERN = re.compile(rf"(?!\s*[-+]?0\d+\s*$)\s*({DECIMAL_REGEX})\s*", re.ASCII)
SHARED_UNIT_PATTERN = re.compile(r"([-+\d.eE,:\s]*[\d.])\s*([^\d\s.,:]+)\s*")
"""Numbers without units, and the unit at the end that is that of all."""
OTHER_RANGE = re.compile(r"\d.*?(\.\.|…|–|(?<!e)-|\bto\b).*\d", re.IGNORECASE)
"""What people write for a range: ``5um..10um``, ``5-10um``, ``5 to 10um``."""
UNIT_FACTOR_PATTERN = re.compile(
    r"(?P<sign>[/*·\s]*)(?P<name>[^\d\s/*·^²³()]+|1)"
    r"(?:(?:\^|\*\*)?(?P<power>[1-9²³]|\(-?\d+(?:/\d+)?\)))?"
)
PREFIX_FACTORS = {
    "": 1.0,
    "p": 1e-12,
    "n": 1e-9,
    "m": 1e-3,
    "c": 1e-2,
    "h": 1e2,
    "k": 1e3,
    "M": 1e6,
}
PREFIX_FACTORS |= dict.fromkeys("µμu", 1e-6)
QUANTITY_OF_UNIT = {
    "m": "a length",
    "m/s": "a speed",
    "s": "a time",
    "Hz": "a frequency",
    "deg": "an angle",
    "rad/m": "a wave number",
    "N": "a force",
    "Pa": "a pressure",
    "Pa s": "a viscosity",
    "kg": "a mass",
    "kg/m³": "a density",
    "K": "a temperature",
}
UNIT_OF_LOWER_CASE = {
    unit.lower(): unit for unit in ("N", "m", "s", "Hz", "rad", "Pa", "W", "kg", "K")
}
UNIT_OF_LOWER_CASE |= {"m3": "m³", "deg": "°", "percent": "%"}
"""How units are called at the end of a name of Python's or a column's: ``stiffness_n_per_m``."""


class Unit(NamedTuple):
    """Size of a unit in BASE_UNITS, and its dimension."""

    size: float
    dimension: Dimension


UNITS = {
    prefix + name: Unit(
        PREFIX_FACTORS[prefix] * size, {base: Fraction(n) for base, n in power.items()}
    )
    for name, prefixes, size, power in (
        ("N", "m", 1.0, {"N": 1}),  # no MN: headers fold the case of mN
        ("m", "muµμncp", 1.0, {"m": 1}),
        ("s", "m", 1.0, {"s": 1}),
        ("deg", "", 1.0, {"deg": 1}),
        ("°", "", 1.0, {"deg": 1}),
        ("rad", "", 180 / math.pi, {"deg": 1}),
        ("Pa", "µumhkM", 1.0, {"N": 1, "m": -2}),
        ("bar", "m", 1e5, {"N": 1, "m": -2}),
        ("Hz", "kM", 1.0, {"s": -1}),
        ("K", "", 1.0, {"K": 1}),
        ("°C", "", 1.0, {"K": 1}),
        ("kg", "", 1.0, {"N": 1, "m": -1, "s": 2}),
        ("g", "m", 1e-3, {"N": 1, "m": -1, "s": 2}),
    )
    for prefix in ("", *prefixes)
}


def dimension_product(a: Dimension, b: Dimension, power: Fraction | int = 1) -> Dimension:
    """The dimension of a · b**power."""
    exponents = {base: a.get(base, 0) + power * b.get(base, 0) for base in {**a, **b}}
    return {base: Fraction(exponent) for base, exponent in exponents.items() if exponent}


def parse_compound_unit(text: str) -> Unit | None:
    """A unit made of others, such as ``kg/m³``, ``Pa s`` or ``1/mm``; None for anything else."""
    text, size, dimension, end = text.strip(), 1.0, DIMENSIONLESS, 0
    for match in UNIT_FACTOR_PATTERN.finditer(text):
        unit = Unit(1.0, DIMENSIONLESS) if match["name"] == "1" else UNITS.get(match["name"])
        sign = match["sign"].strip()
        if match.start() != end or unit is None or sign not in ("", "/", "*", "·"):
            return None
        power = Fraction((match["power"] or "1").strip("()").translate({178: "2", 179: "3"}))
        power = -power if sign == "/" else power
        size *= unit.size ** (int(power) if power.denominator == 1 else float(power))
        dimension, end = dimension_product(dimension, unit.dimension, power), match.end()
    return Unit(size, dimension) if end == len(text) and end else None


def unit_sizes(unit: str) -> dict[str, float]:
    """The simple units that measure what a unit does, each with its size in it."""
    wanted = parse_compound_unit(unit)
    return {name: each.size for name, each in UNITS.items() if wanted and each[1:] == wanted[1:]}


def unit_size(unit: str, *, of: str) -> float:
    """Return the size of a simple unit in another, or of a thousand of it: 1000 of kN/m in N/m."""
    return PREFIX_FACTORS["k"] if unit == f"k{of}" else unit_sizes(of)[unit]


def quantity_examples_text(unit: str) -> str:
    """Two ways to write a quantity with its unit."""
    return " or ".join(f"1 {name}" for name in (list(unit_sizes(unit)) or [unit])[:2])


def number_in_unit(text: str, unit: str) -> float | None:
    """The number of a text such as ``43.27 kHz`` in another unit; None if it has no such unit.

    A number alone is in that unit already.
    """
    match = NUMBER_PATTERN.match(text)
    own = parse_compound_unit(text[match.end() :] or unit) if match else None
    wanted = parse_compound_unit(unit)
    if not match or not own or not wanted or own.dimension != wanted.dimension:
        return None
    # Fifteen digits: 2.2 µm is 2.2e-6 m and not 2.1999999999999997e-6 m.
    zero = 273.15 * (text[match.end() :].strip() == "°C")
    value = float(f"{float(match[1]) * own.size / wanted.size + zero:.15g}")
    return value if math.isfinite(value) else None


def corrected_quantity_text(text: str, unit: str) -> str:
    """Return a quantity with a decimal point and its unit's capitals; empty if it is none then."""
    match = NUMBER_PATTERN.match(pointed := re.sub(r"(?<=\d),(?=\d)", ".", text, count=1))
    written = pointed[match.end() :].strip() if match else ""
    names = [name for name in unit_sizes(unit) if name.lower() == written.lower()]
    name = written if written in names else names[0] if len(names) == 1 else ""
    return f"{match[1]} {name}" if match and name else ""


def quantity_of_unit(unit: str) -> str:
    """Return what a unit measures, such as ``a length``; an empty text if it is none of these."""
    wanted = parse_compound_unit(unit)
    for name, quantity in QUANTITY_OF_UNIT.items():
        known = parse_compound_unit(name)
        if wanted and known and wanted.dimension == known.dimension:
            return quantity
    return ""


def parse_quantity(text: str, *, option: str, unit: str) -> float:
    """A number with its unit, in the given one.

    Raises InputError naming the option, for a text that is no number with such a unit.
    """
    value = None if NUMBER_PATTERN.fullmatch(text) else number_in_unit(text, unit)
    if value is None:
        names = ", ".join(name for name in unit_sizes(unit) if "μ" not in name)  # µ is there too
        corrected = corrected_quantity_text(text, unit)
        hint = f"; did you mean {corrected!r}?" if corrected else ""
        raise InputError(f"{option} {text!r} must be a number with its unit: {names}{hint}")
    return value


def parse_quantities(text: str, *, option: str, unit: str) -> list[float]:
    """One number with its unit, several with commas, or evenly spaced ones as first:last:count.

    Each number has its unit, or one stands at the end for all: ``0.5, 1, 2um``, ``0.5:2.5:9um``.
    Raises InputError naming the option, as quantity does, for a comma that may be a decimal one,
    and for a value that stands twice.
    """
    not_a_range = f"{option} {text!r}: a range is first:last:count, such as 5:10:6um"
    if not set(text) & set(",:"):
        try:
            return [parse_quantity(text, option=option, unit=unit)]
        except InputError as error:
            raise InputError(not_a_range if OTHER_RANGE.search(text) else str(error)) from None
    shared = SHARED_UNIT_PATTERN.fullmatch(text)
    numbers, unit_of_all = shared.groups() if shared else (text, "")
    *ends, count = numbers.split(":")
    if not ends:
        parts = [f"{number.strip()}{unit_of_all}" for number in numbers.split(",")]
        if unit_of_all and re.search(r",\S", numbers):
            may_be_decimal = len(parts) == 2 and "." not in text
            decimal = f"{text.replace(',', '.')}, or " * may_be_decimal
            raise InputError(f"{option} {text!r}: {decimal}{','.join(parts)}? give each its unit")
        values = [parse_quantity(part, option=option, unit=unit) for part in parts]
        return _require_distinct(values, f"{option} {text!r}")
    if len(ends) != 2 or not re.fullmatch(r"\s*\d{1,12}\s*", count, re.ASCII):
        raise InputError(not_a_range)
    if not 2 <= int(count) <= MAX_SPACED_VALUES:
        raise InputError(f"{option} {text!r}: the count must lie within 2 … {MAX_SPACED_VALUES}")
    first, last = (
        parse_quantity(f"{bound}{unit_of_all}", option=option, unit=unit) for bound in ends
    )
    step = (last - first) / (int(count) - 1)
    values = [float(f"{first + step * number:.12g}") for number in range(int(count))]
    return _require_distinct(values, f"{option} {text!r}")


def _require_distinct(values: list[float], given: str) -> list[float]:
    """The values; raises InputError where two are equal, for they would be the same point."""
    if len(set(values)) < len(values):
        raise InputError(f"{given}: a value stands twice; give each value once")
    return values


def round_up_error(error: float) -> float:
    """The next number of two digits that is not below an error; 0 of none."""
    if error == 0 or not math.isfinite(error):
        return error
    digit = 10.0 ** (math.floor(math.log10(error)) - 1)
    return float(f"{math.ceil(round(error / digit, 6)) * digit:.1e}")


def error_text(error: float) -> str:
    """An error rounded up to two digits, both shown: 0.2 is ``0.20``."""
    return f"{round_up_error(error):#.2g}".removesuffix(".")


def value_and_error_texts(value: float, error: float) -> tuple[str, str]:
    """A value up to the last digit of its error, and the error, rounded up to two digits.

    Three digits where the error is not known.
    """
    if not math.isfinite(value):
        return "", ""
    if error == 0:
        return f"{value:zg}", "0"
    if not math.isfinite(error):
        return f"{value:.3g}", "unknown"
    size = round_up_error(abs(error))
    decimals = 1 - math.floor(math.log10(size))
    if 0 <= decimals <= MAX_DECIMALS and max(abs(value), size) >= MIN_VALUE_WITHOUT_EXPONENT:
        return f"{value:z.{decimals}f}", error_text(size)
    # A film that bears next to nothing, or an error of 100 and more: as many digits as that makes.
    value = round(value, decimals)
    digits = math.floor(math.log10(abs(value))) + decimals if value else 1
    return f"{value:z.{digits}e}", error_text(size)


def split_unit(name: str) -> tuple[str, str]:
    """A name without its unit, and the unit as it stands there: ``power`` and ``w``."""
    words = name.split("_")
    for end in range(1, len(words)):
        if {*words[end:]} <= {*UNIT_OF_LOWER_CASE, "per"} and words[-1] != "per":
            return "_".join(words[:end]), "_".join(words[end:])
    return name, ""


def quantity_and_unit_of_column(name: str) -> tuple[str, str]:
    """Quantity of a column, and the unit that its name ends in: ``power_w`` in ``W``."""
    quantity, suffix = split_unit(name)
    above, *below = (
        " ".join(UNIT_OF_LOWER_CASE[word] for word in part.split("_") if word)
        for part in re.split("_?per_", suffix)
    )
    return quantity, above + "".join(f"/({unit})" if " " in unit else f"/{unit}" for unit in below)
