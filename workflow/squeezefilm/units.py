"""Units: of numbers that people write, ``43.27 kHz``, and of the parameters of their formulas.

A dimension maps bases to exponents; a parameter whose unit is not known yet is a base of its own,
and follows from the formula, whose dimensions are linear in the unknown ones.
"""

import math
import re
from collections.abc import Mapping
from fractions import Fraction
from typing import NamedTuple

from squeezefilm.errors import InputError
from squeezefilm.formulas.expressions import Expression, Name, Node, Number

Dimension = Mapping[str, Fraction]

BASES = ("N", "m", "s", "deg")
"""A degree counts as a base: a formula that takes degrees for radians is wrong."""
NONE: Dimension = {}
EXAMPLES = {"deg": "45deg", "N": "0.5N", "Hz": "300Hz", "kg": "50g"}
MOST_LEVELS = 10_000
MOST_PLACES, LEAST_PLAIN = 15, 1e-4
"""Decimals of a value that is shown, and the least that is shown without an exponent."""
DECIMAL = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
NUMBER = re.compile(rf"(?!\s*[-+]?0\d+\s*$)\s*({DECIMAL})\s*", re.ASCII)  # 010 may be an octal 8
SHARED_UNIT = re.compile(r"([-+\d.eE,:\s]*[\d.])\s*([^\d\s.,:]+)\s*")
"""Numbers without units, and the unit at the end that is that of all."""
FACTOR = re.compile(
    r"(?P<sign>[/*·\s]*)(?P<name>[^\d\s/*·^²³()]+|1)"
    r"(?:(?:\^|\*\*)?(?P<power>[1-9²³]|\(-?\d+(?:/\d+)?\)))?"
)
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
    """Its size in BASES, and what it measures."""

    size: float
    dimension: Dimension


UNITS = {
    prefix + name: Unit(PREFIXES[prefix] * size, {base: Fraction(n) for base, n in exponents})
    for name, size, exponents, prefixes in (
        ("N", 1.0, (("N", 1),), ("", "m")),
        ("m", 1.0, (("m", 1),), ("", "m", "u", "µ", "μ", "n", "c", "p")),
        ("s", 1.0, (("s", 1),), ("", "m")),
        ("deg", 1.0, (("deg", 1),), ("",)),
        ("°", 1.0, (("deg", 1),), ("",)),
        ("rad", 180 / math.pi, (("deg", 1),), ("",)),
        ("Pa", 1.0, (("N", 1), ("m", -2)), ("", "µ", "u", "m", "h", "k", "M")),
        ("bar", 1e5, (("N", 1), ("m", -2)), ("",)),
        ("Hz", 1.0, (("s", -1),), ("", "k", "M")),
        ("g", 1e-3, (("N", 1), ("m", -1), ("s", 2)), ("k", "")),
    )
    for prefix in prefixes
}


def times(a: Dimension, b: Dimension, power: Fraction | int = 1) -> Dimension:
    """The dimension of a · b**power."""
    exponents = {base: a.get(base, 0) + power * b.get(base, 0) for base in {**a, **b}}
    return {base: Fraction(exponent) for base, exponent in exponents.items() if exponent}


def compound(text: str) -> Unit | None:
    """A unit made of others, such as ``kg/m³``, ``Pa s`` or ``1/mm``; None for anything else."""
    text, size, dimension, end = text.strip(), 1.0, NONE, 0
    for match in FACTOR.finditer(text):
        unit = Unit(1.0, NONE) if match["name"] == "1" else UNITS.get(match["name"])
        sign = match["sign"].strip()
        if match.start() != end or unit is None or sign not in ("", "/", "*", "·"):
            return None
        power = Fraction((match["power"] or "1").strip("()").translate({178: "2", 179: "3"}))
        power = -power if sign == "/" else power
        size *= unit.size ** (int(power) if power.denominator == 1 else float(power))
        dimension, end = times(dimension, unit.dimension, power), match.end()
    return Unit(size, dimension) if end == len(text) and end else None


def sizes(unit: str) -> dict[str, float]:
    """The simple units that measure what a unit does, each with its size in it."""
    wanted = compound(unit)
    return {name: each.size for name, each in UNITS.items() if wanted and each[1:] == wanted[1:]}


def examples(unit: str) -> str:
    """Two ways to write a quantity with its unit."""
    return " or ".join(f"1 {name}" for name in (list(sizes(unit)) or [unit])[:2])


def in_unit(text: str, unit: str) -> float | None:
    """The number of a text such as ``43.27 kHz`` in another unit; None if it has no such unit.

    A number alone is in that unit already.
    """
    match = NUMBER.match(text)
    own, wanted = compound(text[match.end() :] or unit) if match else None, compound(unit)
    if not match or not own or not wanted or own.dimension != wanted.dimension:
        return None
    # Fifteen digits: 2.2 µm is 2.2e-6 m and not 2.1999999999999997e-6 m.
    value = float(f"{float(match[1]) * own.size / wanted.size:.15g}")
    return value if math.isfinite(value) else None


def quantity(text: str, *, option: str, unit: str) -> float:
    """A number with its unit, in the given one.

    Raises InputError naming the option, for a text that is no number with such a unit.
    """
    value = None if NUMBER.fullmatch(text) else in_unit(text, unit)
    if value is None:
        raise InputError(
            f"{option} {text!r} must be a number with a unit of {unit} ({', '.join(sizes(unit))}), "
            f"such as {EXAMPLES.get(unit, '5um')}"
        )
    return value


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


def parameter_units(
    expression: Expression,
    *,
    units: Mapping[str, str],
    parameters: tuple[str, ...],
    place: str,
) -> dict[str, str]:
    """The units of a formula's parameters, such that all of it fits and a force in N comes out.

    units: those of the factors, and of parameters for which they were declared. A formula whose
    result has no unit is read in newtons.
    Raises InputError naming the part whose units do not fit.
    """
    force, solved = UNITS["N"].dimension, dict[str, Dimension]()
    dimensions = {name: _coherent(unit, place=f"{place}, {name}") for name, unit in units.items()}
    dimensions = {name: {name: Fraction(1)} for name in parameters} | dimensions

    def reduced(dimension: Dimension) -> Dimension:
        """With the parameters that are solved for put in."""
        while known := [name for name in dimension if name in solved]:
            power = dimension[known[0]]
            rest = {name: each for name, each in dimension.items() if name != known[0]}
            dimension = times(rest, solved[known[0]], power)
        return dimension

    def equate(a: Dimension, b: Dimension, otherwise: str) -> None:
        rest = dict(reduced(times(a, b, -1)))
        name = next((each for each in rest if each in parameters), None)
        if name:
            solved[name] = times(NONE, rest, -1 / rest.pop(name))
        elif rest:
            raise InputError(f"{place}: {otherwise}")

    def of(part: Node) -> Dimension:
        if isinstance(part, Number):
            return NONE
        if isinstance(part, Name):
            return dimensions[part.name]
        inner = [of(argument) for argument in part.arguments]
        first, second = (*inner, NONE)[:2]
        match part.operator:
            case "+" | "-":
                a, b = (_in(reduced(each)) for each in (first, second))
                verb = "adds" if part.operator == "+" else "subtracts"
                equate(first, second, f"{part.place!r} {verb} quantities {a} and {b}")
                return first
            case "*" | "/":
                return times(first, second, 1 if part.operator == "*" else -1)
            case "negative" | "abs":
                return first
            case "sqrt":
                return times(NONE, first, Fraction(1, 2))
            case "**" if isinstance(part.arguments[1], Number):
                power = Fraction(part.arguments[1].value).limit_denominator(1000)
                return times(NONE, first, power)
        for each in inner:
            unit = _text(reduced(each))
            hint = "; the angle in radians is called `angle`" if unit == "deg" else ""
            equate(each, NONE, f"{part.place!r} needs a number without unit, not {unit}{hint}")
        return NONE

    result = reduced(of(expression.root))
    if set(result) & set(parameters):
        equate(result, force, "the result must be a force in N")
    elif result not in (force, NONE):
        raise InputError(
            f"{place}: the result is in {_text(result)}; a force in N, or a number, is wanted"
        )
    # What stays open is a parameter that cannot be told from another: any unit would do.
    found = {name: reduced(dimensions[name]) for name in parameters}
    return {
        name: _text({base: each[base] for base in each if base in BASES})
        for name, each in found.items()
    }


def _coherent(text: str, *, place: str) -> Dimension:
    """The dimension of a unit in which formulas are evaluated: SI, or degrees."""
    unit = compound(text)
    if unit is None or unit.size != 1:
        raise InputError(
            f"{place}, unit: {text!r} is no unit of N, m, s, deg, Pa, Hz and kg; write it like "
            "N/m**2"
        )
    return unit.dimension


def _in(dimension: Dimension) -> str:
    return f"in {_text(dimension)}" if dimension else "without unit"


def _text(dimension: Dimension) -> str:
    """A dimension as a unit: N/m**2, 1/deg, 1; a parameter's that is not known yet in brackets."""

    def power(base: str, exponent: Fraction) -> str:
        name = base if base in BASES else f"[{base}]"
        if exponent == 1:
            return name
        return f"{name}**{exponent if exponent.denominator == 1 else f'({exponent})'}"

    order = sorted(dimension, key=lambda base: BASES.index(base) if base in BASES else len(BASES))
    above = [power(base, dimension[base]) for base in order if dimension[base] > 0]
    below = [power(base, -dimension[base]) for base in order if dimension[base] < 0]
    return "/".join(["*".join(above) or "1", *below])
