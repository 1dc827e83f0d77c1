"""Derivatives of formulas, as formulas: exact, or not finite."""

from collections.abc import Callable
from functools import cache

from squeezefilm.formulas.expressions import Name, Node, Number, Operation

ZERO, ONE = Number(0.0), Number(1.0)


def derivative(root: Node, name: str) -> Node:
    """The derivative with respect to a named quantity, as a formula; parts are shared.

    It is exact at removable singularities: the slope of sinc at 0 is 0, and ``sqrt(a*x)``,
    ``abs(a*x)`` and ``x**a`` do not change with a at x = 0. It is not finite at a kink or a
    vertical tangent, even where the rest of the formula makes that smooth, as in ``abs(a)**2`` at
    a = 0.
    """
    varies, alive = _variation(name)

    @cache
    def of(part: Node) -> Node:
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
            case "**":
                by_base = _product(_product(v, _less_by_one(u, v)), du)
                by_exponent = _product(Operation("power times log", (part, u)), dv)
                if isinstance(v, Number) and not 0 < v.value < 1:
                    return by_base
                by_base = _where(_both(varies(u), alive(v)), by_base)
                return _sum(_where(varies(v), by_exponent), by_base)
            case "sqrt" | "abs":
                return _where(varies(u), _product(_slope(part, u), du))
        return _product(_slope(part, u), du)

    return of(root)


def _variation(name: str) -> tuple[Callable[[Node], Node], Callable[[Node], Node]]:
    """Where a part changes with a named quantity, and where it is not zero or will not stay so.

    Both are given as formulas that are not zero there. A factor that is zero, and stays so, makes a
    product constant: the derivative of a function of it is zero, even where the function's own
    slope is infinite.
    """

    @cache
    def varies(part: Node) -> Node:
        if isinstance(part, Number):
            return ZERO
        if isinstance(part, Name):
            return ONE if part.name == name else ZERO
        u, v = (*part.arguments, ONE)[:2]
        either = _either(varies(u), varies(v))
        match part.operator:
            case "*":
                return _both(either, _both(alive(u), alive(v)))
            case "/":
                return _both(either, alive(u))
            case "**":
                either = _both(either, alive(v))
                return _both(either, _either(alive(u), Operation("is not positive", (v,))))
        return either

    def alive(part: Node) -> Node:
        if isinstance(part, Number):
            return ZERO if part == ZERO else ONE
        return _either(varies(part), Operation("is not zero", (part,)))

    return varies, alive


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
            return call("slope of sinc")
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
    if ZERO in (a, b):
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


def _less_by_one(u: Node, v: Node) -> Node:
    """u**(v - 1)."""
    if isinstance(v, Number):
        return _power(u, v.value - 1)
    return Operation("**", (u, _difference(v, ONE)))


def _where(condition: Node, value: Node) -> Node:
    if value is ZERO or condition is ONE:
        return value
    return ZERO if condition is ZERO else Operation("where", (condition, value))


def _either(a: Node, b: Node) -> Node:
    if a is ONE or b is ONE:
        return ONE
    return b if a is ZERO else a if b is ZERO else Operation("or", (a, b))


def _both(a: Node, b: Node) -> Node:
    if a is ZERO or b is ZERO:
        return ZERO
    return b if a is ONE else a if b is ONE else Operation("and", (a, b))
