"""Formulas that a user types: read safely, evaluated with NumPy.

A formula is arithmetic on named quantities and nothing else: + - * / **, numbers, ``pi``, and the
functions of FUNCTIONS. Python's own parser reads the text; every node of its tree is then either
one of these or refused with its place, so that no text can run anything. Size, depth and exponents
are bounded, and constant parts are computed in floating point, so that none can take long either.
"""

from __future__ import annotations

import ast
import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.io.errors import InputError

Array = NDArray[np.float64]

LONGEST = 4000
MOST_PARTS = 1000
DEEPEST = 150
LARGEST_EXPONENT = 32.0
LARGEST_NUMBER = 1e100
CONSTANTS = {"pi": math.pi}


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


OPERATORS: dict[str, Callable[..., Any]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "**": np.power,
    "negative": np.negative,
}
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "atan": np.arctan,
    "abs": np.abs,
    "sinc": np.sinc,  # sin(πx)/(πx), as MATLAB and the paper have it
}


def _slope_of_sinc(u: ArrayLike) -> Any:
    """-π j1(πu), with the spherical Bessel function (cos z - sin(z)/z)/z = -j1(z), exact at 0."""
    from scipy.special import spherical_jn  # few need it, and it takes long to import

    return -np.pi * spherical_jn(1, np.pi * np.asarray(u))


_IN_SLOPES: dict[str, Callable[..., Any]] = {
    "slope of sinc": _slope_of_sinc,
    # Of 0**v with v > 0, which is 0 for every such v.
    "power times log": lambda power, u: np.where((u == 0) & (power == 0), 0.0, power * np.log(u)),
    "where": lambda condition, value: np.where(condition, value, 0.0),
    "is not zero": lambda u: np.not_equal(u, 0.0),
    "is not positive": lambda u: np.less_equal(u, 0.0),
    "and": np.logical_and,
    "or": np.logical_or,
}
"""What occurs in derivatives beside a formula's own operators and functions."""
_BINARY = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
_HINTS: dict[type, str] = {
    ast.BitXor: "a power is written **",
    ast.FloorDiv: "a quotient is written /",
}


@dataclass(frozen=True)
class Expression:
    """A formula that was read: its text and its parts."""

    text: str
    root: Node

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The named quantities that occur, in the order in which they do."""
        return tuple(dict.fromkeys(part.name for part in walk(self.root) if isinstance(part, Name)))

    @cached_property
    def program(self) -> Program:
        return Program([self.root])

    def evaluate(self, **values: ArrayLike) -> Array:
        """The formula's value for named numbers or arrays, which are broadcast together.

        Where it is undefined or overflows the result is NaN or infinite, without a warning.
        """
        return np.asarray(self.program.run(values)[0], dtype=float)


def parse(text: str, *, names: Iterable[str], place: str, known: str = "") -> Expression:
    """Read a formula of the named quantities.

    ``place`` says where it was written, for messages; ``known`` tells the names there, if not one
    by one.
    Raises InputError for anything but arithmetic on these names, with the place and the part that
    is refused; for a formula that is too long, too deep or has too large an exponent.
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
    reader = _Reader(text=text, names=names, place=place, known=known)
    return Expression(text=text, root=reader.read(tree.body, depth=1))


class _Reader:
    """From Python's tree to a formula's parts, refusing all else."""

    def __init__(self, *, text: str, names: tuple[str, ...], place: str, known: str) -> None:
        self.text, self.names, self.place, self.known = text, names, place, known
        self.parts = 0

    def read(self, node: ast.expr, *, depth: int) -> Node:
        self.parts += 1
        if self.parts > MOST_PARTS:
            raise self._refusal(node, f"the formula has more than {MOST_PARTS} parts")
        if depth > DEEPEST:
            raise self._refusal(node, f"the formula is nested more than {DEEPEST} deep")
        if isinstance(node, ast.Constant):
            return self._number(node, node.value)
        if isinstance(node, ast.Name):
            return self._name(node)
        if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
            operator = _BINARY[type(node.op)]
            arguments = [self.read(each, depth=depth + 1) for each in (node.left, node.right)]
            return self._operation(node, operator, arguments)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd):
            return self.read(node.operand, depth=depth + 1)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return self._operation(node, "negative", [self.read(node.operand, depth=depth + 1)])
        if isinstance(node, ast.Call):
            return self._call(node, depth=depth)
        hint = _HINTS.get(type(getattr(node, "op", None)), "")
        allowed = hint or f"allowed are + - * / **, numbers and {', '.join(FUNCTIONS)}"
        raise self._refusal(node, f"this is no arithmetic; {allowed}")

    def _number(self, node: ast.expr, value: object) -> Number:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._refusal(node, "this is not a number")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not abs(number) <= LARGEST_NUMBER:
            raise self._refusal(node, f"the number must lie within ±{LARGEST_NUMBER:g}")
        return Number(number)

    def _name(self, node: ast.Name) -> Number | Name:
        if node.id in self.names:
            return Name(node.id)
        if node.id in CONSTANTS:
            return Number(CONSTANTS[node.id])
        if node.id in FUNCTIONS:
            raise self._refusal(node, f"a function needs its argument: {node.id}(…)")
        raise self._refusal(node, f"this name is unknown; known are {self.known}")

    def _call(self, node: ast.Call, *, depth: int) -> Number | Operation:
        if not (isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS):
            raise self._refusal(
                node.func, f"this is no known function; known are {', '.join(FUNCTIONS)}"
            )
        if node.keywords or len(node.args) != 1:
            raise self._refusal(node, f"{node.func.id} takes one argument")
        argument = self.read(node.args[0], depth=depth + 1)
        return self._operation(node, node.func.id, [argument])

    def _operation(
        self, node: ast.expr, operator: str, arguments: Sequence[Node]
    ) -> Number | Operation:
        if all(isinstance(argument, Number) for argument in arguments):
            values = [np.float64(each.value) for each in arguments if isinstance(each, Number)]
            with np.errstate(all="ignore"):
                value = float(_function(operator)(*values))
            if not abs(value) <= LARGEST_NUMBER:
                raise self._refusal(node, f"this is undefined or exceeds {LARGEST_NUMBER:g}")
            return Number(value)
        if operator == "**" and isinstance(arguments[1], Number):
            exponent = arguments[1].value
            if abs(exponent) > LARGEST_EXPONENT:
                raise self._refusal(
                    node, f"the exponent must lie within ±{LARGEST_EXPONENT:g}, not {exponent:g}"
                )
        return Operation(operator, tuple(arguments), place=self._source(node))

    def _source(self, node: ast.expr) -> str:
        return ast.get_source_segment(self.text, node) or self.text

    def _refusal(self, node: ast.expr, what: str) -> InputError:
        before = self.text.encode()[: node.col_offset]  # Python counts bytes
        column = len(before.decode()) + 1
        return InputError(f"{self.place}: column {column}, {_shown(self._source(node))}: {what}")


def _shown(text: str) -> str:
    """A part of a formula as a message quotes it."""
    return repr(text if len(text) <= 60 else f"{text[:57]}…")


def walk(root: Node) -> list[Node]:
    """All parts, each before those it is made of; a part that is shared comes once."""
    seen: dict[int, Node] = {}
    waiting = [root]
    while waiting:
        part = waiting.pop()
        if id(part) not in seen:
            seen[id(part)] = part
            if isinstance(part, Operation):
                waiting.extend(reversed(part.arguments))
    return list(seen.values())


def _function(operator: str) -> Callable[..., Any]:
    return OPERATORS.get(operator) or FUNCTIONS.get(operator) or _IN_SLOPES[operator]


class Program:
    """Formulas as steps one after the other; equal parts are computed once."""

    def __init__(self, roots: Sequence[Node]) -> None:
        self.inputs: dict[str, int] = {}
        self.constants: dict[int, float] = {}
        self.steps: list[tuple[Callable[..., Any], tuple[int, ...], int]] = []
        self._known: dict[tuple[Any, ...], int] = {}
        self._of: dict[int, int] = {}
        self.outputs = [self._add(root) for root in roots]
        self.slots = len(self._known)
        self._of.clear()

    def _add(self, part: Node) -> int:
        if id(part) in self._of:
            return self._of[id(part)]
        if isinstance(part, Number):
            slot = self._slot(("number", part.value))
            self.constants[slot] = part.value
        elif isinstance(part, Name):
            slot = self._slot(("name", part.name))
            self.inputs[part.name] = slot
        else:
            arguments = tuple(self._add(argument) for argument in part.arguments)
            function = _function(part.operator)
            if part.operator == "**" and part.arguments[1] == Number(2.0):
                function, arguments = np.square, arguments[:1]
            before = len(self._known)
            slot = self._slot((function, arguments))
            if slot == before:
                self.steps.append((function, arguments, slot))
        self._of[id(part)] = slot
        return slot

    def _slot(self, key: tuple[Any, ...]) -> int:
        return self._known.setdefault(key, len(self._known))

    def run(self, values: Mapping[str, ArrayLike]) -> list[Any]:
        """The formulas' values; NaN or infinite where undefined."""
        slots: list[Any] = [None] * self.slots
        for slot, constant in self.constants.items():
            slots[slot] = constant
        for name, slot in self.inputs.items():
            slots[slot] = np.asarray(values[name], dtype=float)
        with np.errstate(all="ignore"):
            for function, arguments, slot in self.steps:
                slots[slot] = function(*[slots[argument] for argument in arguments])
        return [slots[slot] for slot in self.outputs]
