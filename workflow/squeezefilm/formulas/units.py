"""Checking a formula's units: metres are not added to degrees, and a force comes out.

Each part of a formula has a dimension, the exponents of BASES. Those of parameters may be unknown;
they follow from the formula, for its dimensions are linear in them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from squeezefilm.formulas.expressions import Expression, Name, Node, Number, Operation, parse, walk
from squeezefilm.io.errors import InputError
from squeezefilm.units import BASES, UNITS

COHERENT = ("N", "m", "s", "deg", "Pa", "Hz", "kg")
"""Units that parameters may have: formulas are evaluated in SI units, and in degrees."""
FORCE = "N"


@dataclass(frozen=True)
class _Dimension:
    """Known exponents of BASES, and unknown dimensions of parameters to some power."""

    known: tuple[Fraction, ...]
    unknown: tuple[tuple[str, Fraction], ...] = ()

    def times(self, other: _Dimension, power: Fraction = Fraction(1)) -> _Dimension:
        """This times another to a power."""
        unknown = dict(self.unknown)
        for name, exponent in other.unknown:
            unknown[name] = unknown.get(name, Fraction(0)) + power * exponent
        return _Dimension(
            tuple(a + power * b for a, b in zip(self.known, other.known, strict=True)),
            tuple((name, exponent) for name, exponent in unknown.items() if exponent),
        )


NONE = _Dimension((Fraction(0),) * len(BASES))


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
    check = _Check(place)
    dimensions = {name: _read_unit(unit, place=f"{place}, {name}") for name, unit in units.items()}
    for name in parameters:
        dimensions.setdefault(name, _Dimension(NONE.known, ((name, Fraction(1)),)))
    result = check.reduced(check.of(expression.root, dimensions))
    force = _read_unit(FORCE, place=place)
    if result.unknown:
        check.equate(result, force, "the result must be a force in N")
    elif result not in (force, NONE):
        raise InputError(
            f"{place}: the result is in {_text(result)}; a force in N, or a number, is wanted"
        )
    # What stays open is a parameter that cannot be told from another: any unit would do.
    return {name: _text(_Dimension(check.reduced(dimensions[name]).known)) for name in parameters}


class _Check:
    """What is known of the parameters' dimensions so far."""

    def __init__(self, place: str) -> None:
        self.place = place
        self.solved: dict[str, _Dimension] = {}

    def reduced(self, dimension: _Dimension) -> _Dimension:
        """With the parameters that are solved for put in."""
        while True:
            hit = next((pair for pair in dimension.unknown if pair[0] in self.solved), None)
            if hit is None:
                return dimension
            name, exponent = hit
            own = _Dimension(NONE.known, ((name, Fraction(1)),))
            dimension = dimension.times(own, -exponent).times(self.solved[name], exponent)

    def equate(self, a: _Dimension, b: _Dimension, otherwise: str) -> None:
        rest = self.reduced(a.times(b, Fraction(-1)))
        if rest.unknown:
            name, exponent = rest.unknown[0]
            own = _Dimension(NONE.known, ((name, Fraction(1)),))
            others = rest.times(own, -exponent)
            self.solved[name] = NONE.times(others, -1 / exponent)
        elif rest != NONE:
            raise InputError(f"{self.place}: {otherwise}")

    def of(self, part: Node, dimensions: Mapping[str, _Dimension]) -> _Dimension:
        if isinstance(part, Number):
            return NONE
        if isinstance(part, Name):
            return dimensions[part.name]
        inner = [self.of(argument, dimensions) for argument in part.arguments]
        first, second = (*inner, NONE)[:2]
        match part.operator:
            case "+" | "-":
                a, b = (_in(self.reduced(each)) for each in (first, second))
                verb = "adds" if part.operator == "+" else "subtracts"
                self.equate(first, second, f"{part.place!r} {verb} quantities {a} and {b}")
                return first
            case "*":
                return first.times(second)
            case "/":
                return first.times(second, Fraction(-1))
            case "negative" | "abs":
                return first
            case "sqrt":
                return NONE.times(first, Fraction(1, 2))
            case "**" if isinstance(part.arguments[1], Number):
                exponent = Fraction(part.arguments[1].value).limit_denominator(1000)
                return NONE.times(first, exponent)
        for each in inner:
            unit = _text(self.reduced(each))
            hint = "; the angle in radians is called `angle`" if unit == "deg" else ""
            self.equate(each, NONE, f"{part.place!r} needs a number without unit, not {unit}{hint}")
        return NONE


def _read_unit(unit: str, *, place: str) -> _Dimension:
    """The dimension of a unit such as ``N/m**2``; ``1`` for none."""
    expression = parse(unit, names=COHERENT, place=f"{place}, unit")
    bases = {
        name: _Dimension(tuple(Fraction(exponent) for exponent in UNITS[name].exponents))
        for name in COHERENT
    }
    if any(
        isinstance(part, Operation) and part.operator not in ("*", "/", "**")
        for part in walk(expression.root)
    ):
        raise InputError(f"{place}, unit: {unit!r} is no unit; write it like N/m**2")
    return _Check(place).of(expression.root, bases)


def _in(dimension: _Dimension) -> str:
    return "without unit" if dimension == NONE else f"in {_text(dimension)}"


def _text(dimension: _Dimension) -> str:
    """A dimension as a unit: N/m**2, 1/deg, 1; ``?`` for a factor not known yet."""

    def power(base: str, exponent: Fraction) -> str:
        if exponent == 1:
            return base
        whole = exponent.denominator == 1
        return f"{base}**{exponent}" if whole else f"{base}**({exponent})"

    pairs = [
        *zip(BASES, dimension.known, strict=True),
        *((f"[{n}]", e) for n, e in dimension.unknown),
    ]
    above = [power(base, exponent) for base, exponent in pairs if exponent > 0]
    below = [power(base, -exponent) for base, exponent in pairs if exponent < 0]
    text = "*".join(above) or "1"
    if not below:
        return text
    return f"{text}/{below[0]}" if len(below) == 1 else f"{text}/({'*'.join(below)})"
