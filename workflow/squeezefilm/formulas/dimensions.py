"""Units of a formula's parameters, which follow from those of the quantities in it.

A parameter whose unit is not known yet is a base of its own; dimensions are linear in these.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from squeezefilm.errors import InputError
from squeezefilm.formulas.expressions import Expression, Name, Node, Number
from squeezefilm.units import BASES, NONE, UNITS, Dimension, compound, times


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
