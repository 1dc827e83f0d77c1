"""Formulas that a user types: read safely, evaluated with NumPy, the units in them inferred.

A formula is arithmetic on named quantities and nothing else: + - * / **, numbers, ``pi``, and the
functions of FORMULA_FUNCTIONS. Python's own parser reads the text; every node of its tree is then
either one of these or an error that names its place, so that no text can run anything. Length,
depth and exponents are bounded, and constant parts are computed in floating point, so that none can
take long either.

Values may be complex: a formula at θ + ih, h far below round-off, has its derivative with respect
to θ in the imaginary part, without a difference (W. Squire and G. Trapp, Using complex variables to
estimate derivatives of real functions, SIAM Rev. 40 (1998) 110-112). Where the formula has a kink
or a vertical tangent the value is NaN. A formula that is undefined for real numbers may have a
complex value; its real value has to be looked at first.

The units of a formula's parameters follow from those of the quantities in it. A parameter whose
unit is not known yet is an additional base; dimensions are linear in these.
"""

from __future__ import annotations

import ast
import math
import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from operator import itemgetter
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError
from squeezefilm.units import (
    BASE_UNITS,
    DIMENSIONLESS,
    NUMBER_PATTERN,
    UNITS,
    Dimension,
    dimension_product,
    parse_compound_unit,
)

Array = NDArray[Any]
ValueFunction = Callable[[Mapping[str, Any]], Any]
ResultT = TypeVar("ResultT")

MAX_FORMULA_CHARACTERS, MAX_NESTING_DEPTH = 4000, 150
MAX_EXPONENT = 32.0
MAX_CONSTANT = 1e100
NAMED_CONSTANTS = {"pi": math.pi}
EXAMPLE_OF_UNIT = {"m": "12 mm", "1/m": "380 1/m", "deg": "30 deg", "N": "1 mN"}
"""A constant by whose like a unit is taken away."""
UNDEFINED_VALUE = complex(math.nan, math.nan)


@dataclass(frozen=True, eq=False)
class Operation:
    """An operator or function on other parts; ``text`` is its text in the formula."""

    operator: str
    arguments: tuple[Node, ...]
    text: str


class NumberWithUnit(float):
    """A number with a unit, in SI units or degrees; a constant of a formula."""

    dimension: Dimension


def parse_constants(
    values: Mapping[str, str | float],
    *,
    names: Iterable[str],
    source: str,
    angles_rad: bool = False,
) -> dict[str, NumberWithUnit]:
    """The constants of a formula from numbers and texts such as ``12 mm``.

    Args:
        names: what the formula's other names are.
        angles_rad: angles are in radians, not in degrees.

    Raises:
        InputError: naming the source of a text that is no number with a unit, and of a name that
            is another's already.
    """
    constants, taken = {}, (*names, *NAMED_CONSTANTS, *FORMULA_FUNCTIONS)
    for name, value in values.items():
        where, match = f"{source}.constants.{name}", NUMBER_PATTERN.match(str(value))
        if name in taken or not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII):
            raise InputError(
                f"{where}: cannot be a constant's name; take letters, digits and _, and none of "
                f"{', '.join(taken)}"
            )
        unit = match and parse_compound_unit(str(value)[match.end() :] or "1")
        if not (match and unit):
            raise InputError(f"{where}: {value!r} is no number with a unit, like 12 mm or 380 1/m")
        size = unit.size * math.radians(1) ** float(unit.dimension.get("deg", 0) * angles_rad)
        constants[name] = NumberWithUnit(f"{float(match[1]) * size:.15g}")
        constants[name].dimension = unit.dimension
    return constants


Node = float | str | Operation
"""A number, the name of a quantity, or an operation on other parts."""


def fold_formula(
    part: Node,
    leaf: Callable[[Any], ResultT],
    operation: Callable[[Operation, list[ResultT]], ResultT],
) -> ResultT:
    """Evaluate a formula from the values of its numbers and names and from its operations."""
    if not isinstance(part, Operation):
        return leaf(part)
    return operation(part, [fold_formula(argument, leaf, operation) for argument in part.arguments])


def _zero_and_varying_mask(z: Any) -> Any:
    """Mask of values that are zero and change with the quantity that has the complex step."""
    return (np.imag(z) != 0) & (np.abs(np.real(z)) <= np.abs(np.imag(z)))


def _square_root(z: Any) -> Any:
    if not np.iscomplexobj(z):
        return np.sqrt(z)
    return np.where((z != 0) & (z.real <= np.abs(z.imag)), UNDEFINED_VALUE, np.sqrt(z))


def _absolute(z: Any) -> Any:
    if not np.iscomplexobj(z):
        return np.abs(z)
    return np.where(_zero_and_varying_mask(z), UNDEFINED_VALUE, np.sign(z.real) * z)


def _sinc(z: Any) -> Any:
    """sin(πz)/(πz); its slope is -π j1(πz), with the spherical Bessel function, exact at 0."""
    if not np.iscomplexobj(z):
        return np.sinc(z)
    from scipy.special import spherical_jn  # few need it, and it takes long to import

    return np.sinc(z.real) - 1j * np.pi * spherical_jn(1, np.pi * z.real) * z.imag


def _power(base: Any, exponent: Any) -> Any:
    if isinstance(exponent, float) and exponent == 2:
        return np.square(base)
    if not (np.iscomplexobj(base) or np.iscomplexobj(exponent)):
        return np.power(base, exponent)
    zero = (base == 0) & (np.real(exponent) > 0)  # 0**v is 0 for every such v
    vertical = _zero_and_varying_mask(base) & (np.real(exponent) < 1) & (exponent != 0)
    undefined = vertical | ((np.real(base) < 0) & (np.imag(exponent) != 0))
    return np.where(zero, 0, np.where(undefined, UNDEFINED_VALUE, np.power(base + 0j, exponent)))


FORMULA_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sqrt": _square_root,
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "atan": np.arctan,
    "abs": _absolute,
    "sinc": _sinc,  # as MATLAB and the paper have it
}
_FUNCTION_OF_OPERATOR: dict[str, Callable[..., Any]] = FORMULA_FUNCTIONS | {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "**": _power,
    "negative": np.negative,
}
_OPERATOR_OF_AST_NODE = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
_HINT_OF_AST_NODE: dict[type, str] = {
    ast.BitXor: "a power is written **",
    ast.FloorDiv: "a quotient is written /",
}


@dataclass(frozen=True)
class Expression:
    """A formula that was read: its text, its parts, and the names in it as they occur."""

    text: str
    root: Node = field(compare=False)
    names: tuple[str, ...]

    def evaluate(self, **values: ArrayLike) -> Array:
        """The formula's value for named numbers or arrays, which are broadcast together.

        Where it is undefined or overflows the result is NaN or infinite, without a warning.
        """
        with np.errstate(all="ignore"):
            value = self._value_function({name: np.asarray(values[name]) for name in self.names})
        return np.asarray(value) + 0.0  # whole numbers as floating-point ones

    @cached_property
    def _value_function(self) -> ValueFunction:
        return self.partial_value_function({})

    def partial_value_function(self, known: Mapping[str, Any]) -> ValueFunction:
        """The formula as nested functions of the values that are not known yet.

        A fit evaluates them many thousand times: what known values alone decide is computed once.
        """

        def leaf_function(part: Any) -> Any:
            return known.get(part, part if isinstance(part, float) else itemgetter(part))

        def operation_function(part: Operation, arguments: list[Any]) -> Any:
            operator = _FUNCTION_OF_OPERATOR[part.operator]
            if not any(map(callable, arguments)):
                return operator(*arguments)
            ready = [each if callable(each) else lambda _, each=each: each for each in arguments]
            first, last = ready[0], ready[-1]
            if len(arguments) == 1:
                return lambda values: operator(first(values))
            return lambda values: operator(first(values), last(values))

        with np.errstate(all="ignore"):
            value = fold_formula(self.root, leaf_function, operation_function)
        return value if callable(value) else lambda values: value


def parse_formula(
    text: str,
    *,
    names: Iterable[str],
    source: str,
    known: str = "",
    constants: Mapping[str, NumberWithUnit] = MappingProxyType({}),
) -> Expression:
    """Read a formula of the named quantities and of constants.

    ``source`` says where it was written, for messages; ``known`` tells the names there, if not one
    by one.
    Raises InputError for anything but arithmetic on these names, with the place and the part that
    is not allowed; for a formula that is too long, too deep or has too large an exponent.
    """
    text = " ".join(text.split())
    if not text:
        raise InputError(f"{source}: the formula is empty")
    if "#" in text or "\\" in text:
        raise InputError(f"{source}: {_quoted_part(text)}: # and \\ have no meaning in a formula")
    if len(text) > MAX_FORMULA_CHARACTERS:
        raise InputError(
            f"{source}: the formula has {len(text)} characters; at most {MAX_FORMULA_CHARACTERS} "
            "are allowed"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about odd spellings, which are refused below
            tree = ast.parse(text, mode="eval")
    except SyntaxError as error:
        # Python's message, without its advice, which is about programs.
        what = (error.msg or "not a formula").split(".")[0].split(" Perhaps")[0]
        raise InputError(f"{source}: {_quoted_part(text)}: {what}") from None
    except (ValueError, RecursionError, MemoryError):
        raise InputError(f"{source}: {_quoted_part(text)}: the formula cannot be read") from None
    names, used = tuple(names), dict[str, None]()

    def node_text(node: ast.expr) -> str:
        return ast.get_source_segment(text, node) or text

    def formula_error(node: ast.expr, what: str) -> InputError:
        before = text.encode()[: node.col_offset]  # Python counts bytes
        column = len(before.decode()) + 1
        return InputError(f"{source}: column {column}, {_quoted_part(node_text(node))}: {what}")

    def parse_node(node: ast.expr, depth: int = 1) -> Node:
        """A formula's part of Python's tree; anything else is an error."""
        if depth > MAX_NESTING_DEPTH:
            raise formula_error(node, f"the formula is nested more than {MAX_NESTING_DEPTH} deep")
        match node:
            case ast.Constant(int() | float() as value) if not isinstance(value, bool):
                if not abs(value) <= MAX_CONSTANT:
                    raise formula_error(node, f"the number must lie within ±{MAX_CONSTANT:g}")
                return float(value)
            case ast.Constant():
                raise formula_error(node, "this is not a number")
            case ast.Name(name) if name in names:
                used[name] = None
                return name
            case ast.Name(name) if name in constants:
                return constants[name]
            case ast.Name(name) if name in NAMED_CONSTANTS:
                return NAMED_CONSTANTS[name]
            case ast.Name(name) if name in FORMULA_FUNCTIONS:
                raise formula_error(node, f"a function needs its argument: {name}(…)")
            case ast.Name(name):
                listed = ", ".join([known or ", ".join((*names, *NAMED_CONSTANTS)), *constants])
                raise formula_error(
                    node,
                    f"this name is unknown; known are {listed}. A number of your own is a "
                    f"constant beside the expression, as in constants: {{{name}: 12 mm}}",
                )
            case ast.UnaryOp(ast.UAdd(), operand):
                return parse_node(operand, depth + 1)
            case ast.UnaryOp(ast.USub(), operand):
                operator, operands = "negative", [operand]
            case ast.BinOp(left, op, right) if type(op) in _OPERATOR_OF_AST_NODE:
                operator, operands = _OPERATOR_OF_AST_NODE[type(op)], [left, right]
            case ast.Call(ast.Name(operator), operands, keywords) if operator in FORMULA_FUNCTIONS:
                if keywords or len(operands) != 1:
                    raise formula_error(node, f"{operator} takes one argument")
            case ast.Call(function):
                allowed = ", ".join(FORMULA_FUNCTIONS)
                raise formula_error(function, f"this is no known function; known are {allowed}")
            case _:
                hint = _HINT_OF_AST_NODE.get(type(getattr(node, "op", None)), "")
                allowed = (
                    hint or f"allowed are + - * / **, numbers and {', '.join(FORMULA_FUNCTIONS)}"
                )
                raise formula_error(node, f"this is no arithmetic; {allowed}")
        arguments = [parse_node(operand, depth + 1) for operand in operands]
        numbers = [np.float64(argument) for argument in arguments if type(argument) is float]
        if len(numbers) == len(arguments):
            with np.errstate(all="ignore"):
                value = float(_FUNCTION_OF_OPERATOR[operator](*numbers))
            if not abs(value) <= MAX_CONSTANT:
                raise formula_error(node, f"this is undefined or exceeds {MAX_CONSTANT:g}")
            return value
        exponent = arguments[-1]
        if operator == "**" and isinstance(exponent, float) and abs(exponent) > MAX_EXPONENT:
            what = f"the exponent must lie within ±{MAX_EXPONENT:g}, not {exponent:g}"
            raise formula_error(node, what)
        return Operation(operator, tuple(arguments), text=node_text(node))

    return Expression(text, parse_node(tree.body), tuple(used))


def _quoted_part(text: str) -> str:
    """A part of a formula as a message quotes it."""
    return repr(text if len(text) <= 60 else f"{text[:57]}…")


def parameter_units(
    expression: Expression, *, units: Mapping[str, str], parameters: tuple[str, ...], source: str
) -> dict[str, str]:
    """The units of a formula's parameters, such that all of it fits and a force in N comes out.

    units: those of the factors, and of parameters for which they were declared. A formula whose
    result has no unit is read in newtons.
    Raises InputError naming the part whose units do not fit.
    """
    force, solved = UNITS["N"].dimension, dict[str, Dimension]()
    dimensions = {
        name: _dimension_of_coherent_unit(unit, source=f"{source}, {name}")
        for name, unit in units.items()
    }
    dimensions = {name: {name: Fraction(1)} for name in parameters} | dimensions

    def substitute_solved_parameters(dimension: Dimension) -> Dimension:
        """Insert the parameters that are solved for."""
        while name := next((factor for factor in dimension if factor in solved), None):
            power = dimension[name]
            dimension = dimension_product(
                dimension_product(dimension, {name: power}, -1), solved[name], power
            )
        return dimension

    def equate_dimensions(a: Dimension, b: Dimension, otherwise: str) -> None:
        rest = dict(substitute_solved_parameters(dimension_product(a, b, -1)))
        name = next((parameter for parameter in rest if parameter in parameters), None)
        if name:
            solved[name] = dimension_product(DIMENSIONLESS, rest, -1 / rest.pop(name))
        elif rest:
            raise InputError(f"{source}: {otherwise}")

    def operation_dimension(part: Operation, inner: list[Dimension]) -> Dimension:
        first, second = (*inner, DIMENSIONLESS)[:2]
        match part.operator:
            case "+" | "-":
                a, b = (
                    f"in {_dimension_text(d)}" if d else "without unit"
                    for d in map(substitute_solved_parameters, inner)
                )
                verb = "adds" if part.operator == "+" else "subtracts"
                equate_dimensions(first, second, f"{part.text!r} {verb} quantities {a} and {b}")
                return first
            case "*" | "/":
                return dimension_product(first, second, 1 if part.operator == "*" else -1)
            case "negative" | "abs":
                return first
            case "sqrt":
                return dimension_product(DIMENSIONLESS, first, Fraction(1, 2))
            case "**" if isinstance(exponent := part.arguments[1], float):
                return dimension_product(
                    DIMENSIONLESS, first, Fraction(exponent).limit_denominator(1000)
                )
        for dimension in inner:
            unit = _dimension_text(substitute_solved_parameters(dimension))
            hint = "; the angle in radians is called `angle`" if unit == "deg" else ""
            if unit in EXAMPLE_OF_UNIT:
                hint += (
                    f"; give a number its unit by `constants: {{name: {EXAMPLE_OF_UNIT[unit]}}}`"
                )
            equate_dimensions(
                dimension,
                DIMENSIONLESS,
                f"{part.text!r} needs a number without unit, not {unit}{hint}",
            )
        return DIMENSIONLESS

    def leaf_dimension(part: Any) -> Dimension:
        return (
            part.dimension
            if isinstance(part, NumberWithUnit)
            else dimensions.get(part, DIMENSIONLESS)
        )

    result = substitute_solved_parameters(
        fold_formula(expression.root, leaf_dimension, operation_dimension)
    )
    if set(result) & set(parameters):
        equate_dimensions(result, force, "the result must be a force in N")
    elif result not in (force, DIMENSIONLESS):
        raise InputError(
            f"{source}: the result is in {_dimension_text(result)}; a force in N, or a number, "
            f"is wanted"
        )
    # What stays open is a parameter that cannot be told from another: any unit would do.
    found = {name: substitute_solved_parameters(dimensions[name]) for name in parameters}
    return {
        name: _dimension_text({base: dimension[base] for base in dimension if base in BASE_UNITS})
        for name, dimension in found.items()
    }


def _dimension_of_coherent_unit(text: str, *, source: str) -> Dimension:
    """The dimension of a unit in which formulas are evaluated: SI, or degrees."""
    unit = parse_compound_unit(text)
    if unit is None or unit.size != 1:
        raise InputError(
            f"{source}, unit: {text!r} is no unit of N, m, s, deg, Pa, Hz and kg; write it like "
            "N/m**2"
        )
    return unit.dimension


def _dimension_text(dimension: Dimension) -> str:
    """A dimension as a unit: N/m**2, 1/deg, 1; a parameter's that is not known yet in brackets."""

    def power_text(base: str, exponent: Fraction) -> str:
        name = base if base in BASE_UNITS else f"[{base}]"
        if exponent == 1:
            return name
        return f"{name}**{exponent if exponent.denominator == 1 else f'({exponent})'}"

    order = sorted(dimension, key=[*BASE_UNITS, *dimension].index)
    above = [power_text(base, dimension[base]) for base in order if dimension[base] > 0]
    below = [power_text(base, -dimension[base]) for base in order if dimension[base] < 0]
    return "/".join(["*".join(above) or "1", *below])
