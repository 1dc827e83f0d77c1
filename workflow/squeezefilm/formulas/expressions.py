"""Formulas that a user types: read safely, evaluated with NumPy.

A formula is arithmetic on named quantities and nothing else: + - * / **, numbers, ``pi``, and the
functions of FUNCTIONS. Python's own parser reads the text; every node of its tree is then either
one of these or an error that names its place, so that no text can run anything. Size, depth and
exponents are bounded, and constant parts are computed in floating point, so that none can take long
either.

Values may be complex: a formula at θ + ih, h far below round-off, has its derivative with respect
to θ in the imaginary part, without a difference (W. Squire and G. Trapp, Using complex variables to
estimate derivatives of real functions, SIAM Rev. 40 (1998) 110-112). Where the formula has a kink
or a vertical tangent the value is NaN. A formula that is undefined for real numbers may have a
complex value; its real value has to be looked at first.
"""

from __future__ import annotations

import ast
import math
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError

Array = NDArray[Any]

LONGEST = 4000
MOST_PARTS = 1000
DEEPEST = 150
LARGEST_EXPONENT = 32.0
LARGEST_NUMBER = 1e100
CONSTANTS = {"pi": math.pi}
UNDEFINED = complex(math.nan, math.nan)


@dataclass(frozen=True)
class Number:
    """A constant."""

    value: float


@dataclass(frozen=True)
class Name:
    """A quantity whose value is given when the formula is evaluated."""

    name: str


@dataclass(frozen=True, eq=False)
class Operation:
    """An operator or function on other parts; ``place`` is its text in the formula."""

    operator: str
    arguments: tuple[Node, ...]
    place: str = ""


Node = Number | Name | Operation


def _at_zero(z: Any) -> Any:
    """Where a value is zero and changes with the quantity that has the complex step."""
    return (np.imag(z) != 0) & (np.abs(np.real(z)) <= np.abs(np.imag(z)))


def _square_root(z: Any) -> Any:
    if not np.iscomplexobj(z):
        return np.sqrt(z)
    return np.where((z != 0) & (z.real <= np.abs(z.imag)), UNDEFINED, np.sqrt(z))


def _absolute(z: Any) -> Any:
    if not np.iscomplexobj(z):
        return np.abs(z)
    return np.where(_at_zero(z), UNDEFINED, np.sign(z.real) * z)


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
    vertical = _at_zero(base) & (np.real(exponent) < 1) & (exponent != 0)
    undefined = vertical | ((np.real(base) < 0) & (np.imag(exponent) != 0))
    return np.where(zero, 0, np.where(undefined, UNDEFINED, np.power(base + 0j, exponent)))


OPERATORS: dict[str, Callable[..., Any]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "**": _power,
    "negative": np.negative,
}
FUNCTIONS: dict[str, Callable[..., Any]] = {
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
_BINARY = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
_HINTS: dict[type, str] = {
    ast.BitXor: "a power is written **",
    ast.FloorDiv: "a quotient is written /",
}


@dataclass(frozen=True)
class Expression:
    """A formula that was read: its text and its parts."""

    text: str
    root: Node = field(compare=False)

    @cached_property
    def parts(self) -> list[Node]:
        """All parts, each after those it is made of; one that occurs twice is here once."""
        seen: dict[int, Node] = {}

        def visit(part: Node) -> None:
            if id(part) not in seen:
                for argument in part.arguments if isinstance(part, Operation) else ():
                    visit(argument)
                seen[id(part)] = part

        visit(self.root)
        return list(seen.values())

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The named quantities that occur, in the order in which they do."""
        return tuple(part.name for part in self.parts if isinstance(part, Name))

    def evaluate(self, **values: ArrayLike) -> Array:
        """The formula's value for named numbers or arrays, which are broadcast together.

        Where it is undefined or overflows the result is NaN or infinite, without a warning.
        """
        known: dict[int, Any] = {}
        with np.errstate(all="ignore"):
            for part in self.parts:
                if isinstance(part, Number):
                    known[id(part)] = part.value
                elif isinstance(part, Name):
                    known[id(part)] = np.asarray(values[part.name])
                else:
                    arguments = [known[id(each)] for each in part.arguments]
                    known[id(part)] = _function(part.operator)(*arguments)
        return np.asarray(known[id(self.root)]) + 0.0  # whole numbers as floating-point ones


def parse(text: str, *, names: Iterable[str], place: str, known: str = "") -> Expression:
    """Read a formula of the named quantities.

    ``place`` says where it was written, for messages; ``known`` tells the names there, if not one
    by one.
    Raises InputError for anything but arithmetic on these names, with the place and the part that
    is not allowed; for a formula that is too long, too deep or has too large an exponent.
    """
    if not isinstance(text, str):
        raise InputError(f"{place}: a formula is text, not {text!r}")
    text = " ".join(text.split())
    if not text:
        raise InputError(f"{place}: the formula is empty")
    if "#" in text or "\\" in text:
        raise InputError(f"{place}: {_shown(text)}: # and \\ have no meaning in a formula")
    if len(text) > LONGEST:
        raise InputError(
            f"{place}: the formula has {len(text)} characters; at most {LONGEST} are allowed"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about odd spellings, which are refused below
            tree = ast.parse(text, mode="eval")
    except SyntaxError as error:
        # Python's message, without its advice, which is about programs.
        what = (error.msg or "not a formula").split(".")[0].split(" Perhaps")[0]
        raise InputError(f"{place}: {_shown(text)}: {what}") from None
    except (ValueError, RecursionError, MemoryError):
        raise InputError(f"{place}: {_shown(text)}: the formula cannot be read") from None
    names = tuple(names)
    known = known or ", ".join((*names, *CONSTANTS))
    return Expression(text, _Reader(text, names, place, known).read(tree.body))


@dataclass
class _Reader:
    """From Python's tree to a formula's parts; anything else is an error."""

    text: str
    names: tuple[str, ...]
    place: str
    known: str
    count: int = 0
    shared: dict[tuple[Any, ...], Node] = field(default_factory=dict)
    """Parts by what they are: equal ones are one."""

    def read(self, node: ast.expr, *, depth: int = 1) -> Node:
        self.count += 1
        if self.count > MOST_PARTS:
            raise self._error(node, f"the formula has more than {MOST_PARTS} parts")
        if depth > DEEPEST:
            raise self._error(node, f"the formula is nested more than {DEEPEST} deep")
        match node:
            case ast.Constant(value):
                return self._number(node, value)
            case ast.Name(name):
                return self._name(node, name)
            case ast.UnaryOp(ast.UAdd(), operand):
                return self.read(operand, depth=depth + 1)
            case ast.UnaryOp(ast.USub(), operand):
                operator, operands = "negative", [operand]
            case ast.BinOp(left, op, right) if type(op) in _BINARY:
                operator, operands = _BINARY[type(op)], [left, right]
            case ast.Call(ast.Name(operator), operands, keywords) if operator in FUNCTIONS:
                if keywords or len(operands) != 1:
                    raise self._error(node, f"{operator} takes one argument")
            case ast.Call(function):
                allowed = ", ".join(FUNCTIONS)
                raise self._error(function, f"this is no known function; known are {allowed}")
            case _:
                hint = _HINTS.get(type(getattr(node, "op", None)), "")
                allowed = hint or f"allowed are + - * / **, numbers and {', '.join(FUNCTIONS)}"
                raise self._error(node, f"this is no arithmetic; {allowed}")
        return self._operation(node, operator, [self.read(e, depth=depth + 1) for e in operands])

    def _number(self, node: ast.expr, value: object) -> Node:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._error(node, "this is not a number")
        if not abs(value) <= LARGEST_NUMBER:
            raise self._error(node, f"the number must lie within ±{LARGEST_NUMBER:g}")
        return self._once(Number(float(value)), float(value))

    def _name(self, node: ast.expr, name: str) -> Node:
        if name in self.names:
            return self._once(Name(name), name)
        if name in CONSTANTS:
            return self._once(Number(CONSTANTS[name]), CONSTANTS[name])
        if name in FUNCTIONS:
            raise self._error(node, f"a function needs its argument: {name}(…)")
        raise self._error(node, f"this name is unknown; known are {self.known}")

    def _operation(self, node: ast.expr, operator: str, arguments: list[Node]) -> Node:
        numbers = [np.float64(each.value) for each in arguments if isinstance(each, Number)]
        if len(numbers) == len(arguments):
            with np.errstate(all="ignore"):
                value = float(_function(operator)(*numbers))
            if not abs(value) <= LARGEST_NUMBER:
                raise self._error(node, f"this is undefined or exceeds {LARGEST_NUMBER:g}")
            return self._once(Number(value), value)
        if operator == "**" and isinstance(arguments[1], Number):
            exponent = arguments[1].value
            if abs(exponent) > LARGEST_EXPONENT:
                raise self._error(
                    node, f"the exponent must lie within ±{LARGEST_EXPONENT:g}, not {exponent:g}"
                )
        part = Operation(operator, tuple(arguments), place=self._source(node))
        return self._once(part, operator, *map(id, arguments))

    def _once(self, part: Node, *key: Any) -> Node:
        return self.shared.setdefault(key, part)

    def _source(self, node: ast.expr) -> str:
        return ast.get_source_segment(self.text, node) or self.text

    def _error(self, node: ast.expr, what: str) -> InputError:
        before = self.text.encode()[: node.col_offset]  # Python counts bytes
        column = len(before.decode()) + 1
        return InputError(f"{self.place}: column {column}, {_shown(self._source(node))}: {what}")


def _shown(text: str) -> str:
    """A part of a formula as a message quotes it."""
    return repr(text if len(text) <= 60 else f"{text[:57]}…")


def _function(operator: str) -> Callable[..., Any]:
    return OPERATORS.get(operator) or FUNCTIONS[operator]
