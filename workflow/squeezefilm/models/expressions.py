"""Formulas that a user types: read safely, evaluated with NumPy, differentiated, printed as code.

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

from squeezefilm.errors import InputError

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

    Raises:
        InputError: for anything but arithmetic on these names, with the place and the part that
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
    return OPERATORS.get(operator) or FUNCTIONS[operator]


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


ZERO, ONE = Number(0.0), Number(1.0)


def derivative(root: Node, name: str) -> Node:
    """The derivative with respect to a named quantity, as a formula; parts are shared."""
    known: dict[int, Node] = {}

    def of(part: Node) -> Node:
        if id(part) not in known:
            known[id(part)] = rule(part)
        return known[id(part)]

    def rule(part: Node) -> Node:
        if isinstance(part, Number):
            return ZERO
        if isinstance(part, Name):
            return ONE if part.name == name else ZERO
        inner = [of(argument) for argument in part.arguments]
        if all(each is ZERO for each in inner):
            return ZERO
        u, v = (*part.arguments, ONE)[:2]
        du, dv = (*inner, ZERO)[:2]
        match part.operator:
            case "+":
                return _sum(du, dv)
            case "-":
                return _difference(du, dv)
            case "*":
                return _sum(_product(du, v), _product(u, dv))
            case "/":
                return _difference(_quotient(du, v), _quotient(_product(part, dv), v))
            case "negative":
                return _difference(ZERO, du)
            case "**" if isinstance(v, Number):
                return _product(_product(v, _power(u, v.value - 1)), du)
            case "**":
                by_base = ZERO if du is ZERO else _product(v, _quotient(du, u))
                by_exponent = ZERO if dv is ZERO else _product(dv, Operation("log", (u,)))
                return _product(part, _sum(by_exponent, by_base))
        return _product(_slope(part, u), du)

    return of(root)


def _slope(part: Operation, u: Node) -> Node:
    """Derivative of a function with respect to its argument."""

    def call(name: str) -> Operation:
        return Operation(name, (u,))

    match part.operator:
        case "sqrt":
            return _quotient(Number(0.5), part)
        case "exp":
            return part
        case "log":
            return _quotient(ONE, u)
        case "sin":
            return call("cos")
        case "cos":
            return _difference(ZERO, call("sin"))
        case "tan":
            return _sum(ONE, _power(part, 2.0))
        case "sinh":
            return call("cosh")
        case "cosh":
            return call("sinh")
        case "tanh":
            return _difference(ONE, _power(part, 2.0))
        case "atan":
            return _quotient(ONE, _sum(ONE, _power(u, 2.0)))
        case "abs":
            return _quotient(u, part)
        case "sinc":
            cosine = Operation("cos", (_product(Number(math.pi), u),))
            return _quotient(_difference(cosine, part), u)
    raise AssertionError(part.operator)


def _sum(a: Node, b: Node) -> Node:
    if a is ZERO or b is ZERO:
        return b if a is ZERO else a
    return Operation("+", (a, b))


def _difference(a: Node, b: Node) -> Node:
    if b is ZERO:
        return a
    return Operation("negative", (b,)) if a is ZERO else Operation("-", (a, b))


def _product(a: Node, b: Node) -> Node:
    if a is ZERO or b is ZERO:
        return ZERO
    if a == ONE or b == ONE:
        return b if a == ONE else a
    return Operation("*", (a, b))


def _quotient(a: Node, b: Node) -> Node:
    return ZERO if a is ZERO else Operation("/", (a, b))


def _power(u: Node, exponent: float) -> Node:
    if exponent in (0.0, 1.0):
        return ONE if exponent == 0.0 else u
    return Operation("**", (u, Number(exponent)))
