"""Formulas of users: what is read, what is refused, and that derivatives are right."""

import time

import numpy as np
import pytest

from squeezefilm.errors import InputError
from squeezefilm.formulas import FORMULA_FUNCTIONS, Expression, parse_formula

NAMES = ("a", "b", "x", "h0")


def read(text: str):
    return parse_formula(text, names=NAMES, source="model")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2*3 - 4/8", 6.5),
        ("-a**2", -9.0),
        ("sin(pi/2) + cos(0) + tanh(0)", 2.0),
        ("sinc(0.5*b)", 0.0),  # sin(πx)/(πx), not sin(x)/x
        ("(a\n + b)", 5.0),
    ],
)
def test_arithmetic_means_what_it_means_in_python(text, value):
    assert float(read(text).evaluate(a=3.0, b=2.0)) == pytest.approx(value, abs=1e-15)


def test_a_formula_of_arrays_is_broadcast_and_never_warns():
    found = read("sqrt(a)/b").evaluate(a=np.array([[4.0], [-1.0]]), b=np.array([2.0, 0.0]))
    np.testing.assert_array_equal(found, [[1.0, np.inf], [np.nan, np.nan]])


HOSTILE = {
    "__import__('os').system('true')": "no known function",
    "a.real": "no arithmetic",
    "a^2": r"\*\*",
    "9**9**9": "exceeds",
    "unknown + 1": "unknown",
    "a + " * 1500 + "a": "characters",
    "(" * 400 + "a" + ")" * 400: "parentheses",
    "a+" * 1100 + "a": "",
}


@pytest.mark.parametrize("text", HOSTILE, ids=lambda text: text[:20])
def test_a_hostile_formula_is_refused_with_its_place_and_does_not_hang(text):
    started = time.process_time()
    with pytest.raises(InputError, match=f"^model: .*{HOSTILE[text]}"):
        read(text)
    assert time.process_time() - started < 10


FORMULAS = [
    "sqrt(1 + a*(x/h0)**2)/sqrt(1 - b*(x/h0)**2) + a",
    "a*x**b",
    "(x/h0)**(a + b)",
    "a/(b + x) - b*a",
    "-(a - x)*(b - a*b)**3",
    "a**0.5 * x**-2 + 2**a",
    "b*sinc(a*x)*x + b*abs(a*x - b*x) + (a*0)**b",
    "sqrt(a*x**2 + b*x) + (a*x)**0.3 + x**(a + b) + abs(a*x)**b",
    *(f"{name}(0.3*a*b + 0.1*x) * b" for name in FORMULA_FUNCTIONS),
]


def slope(formula: Expression, values: dict, name: str) -> np.ndarray:
    """Derivative with respect to a named quantity, by a complex step."""
    return formula.evaluate(**values | {name: values[name] + 1e-30j}).imag / 1e-30


def test_the_slope_of_sinc_is_exact_down_to_zero():
    """(cos πu - sinc u)/u loses every digit below 1e-8; by Taylor it is -π²u/3 + π⁴u³/30."""
    u = np.array([0.0, 1e-100, -1e-12, 1e-8, 1e-5, -1e-3])
    series = -(np.pi**2) * u / 3 + np.pi**4 * u**3 / 30 - np.pi**6 * u**5 / 840
    np.testing.assert_allclose(slope(read("sinc(a)"), {"a": u}, "a"), series, rtol=1e-14, atol=0)


@pytest.mark.parametrize(
    "text", ["abs(a)", "sqrt(a)", "a**0.5", "abs(a - x)", "x**a", "sqrt(a**2)", "abs(a)**2"]
)
def test_a_kink_or_a_vertical_tangent_has_no_derivative(text):
    assert not np.isfinite(slope(read(text), {"a": 0.0, "x": 0.0}, "a"))


@pytest.mark.parametrize("text", ["sqrt(a*x)", "abs(a*x)", "x**(a + 1)", "(a*x)**0.3", "(a*x)**a"])
def test_what_is_zero_and_stays_so_has_the_derivative_zero(text):
    assert slope(read(text), {"a": 0.7, "x": 0.0}, "a") == 0


def random_formula(rng: np.random.Generator, depth: int) -> str:
    if depth == 0 or rng.random() < 0.15:
        return str(rng.choice([*NAMES, "1", "2.5", "pi", "0", "1e30", "1e-30"]))
    kind = rng.integers(4)
    inner = random_formula(rng, depth - 1)
    if kind == 0:
        return f"{rng.choice(list(FORMULA_FUNCTIONS))}({inner})"
    if kind == 1:
        return f"(-{inner})"
    operator = rng.choice(["+", "-", "*", "/", "**"])
    return f"({inner} {operator} {random_formula(rng, depth - 1)})"


def read_or_none(text: str) -> Expression | None:
    """The formula, or none where it is refused; a refusal must name its place."""
    message = ""
    try:
        return read(text)
    except InputError as error:
        message = str(error)
    assert message.startswith("model: ")
    return None


def one_sided(formula: Expression, values: dict, step: float) -> np.ndarray:
    """Slope by a from one side, of second order, where it no longer depends on the step; or NaN."""

    def by(h: float) -> np.ndarray:
        at = [formula.evaluate(**values | {"a": values["a"] + k * h}) for k in range(3)]
        at = np.broadcast_arrays(values["a"], *at)[1:]
        return (-1.5 * at[0] + 2 * at[1] - 0.5 * at[2]) / h

    with np.errstate(all="ignore"):
        fine, coarse = by(step), by(2 * step)
        return np.where(np.abs(fine - coarse) < 1e-4 * (1 + np.abs(fine)), fine, np.nan)


def test_a_finite_derivative_is_right_from_both_sides_at_zeros_too():
    rng = np.random.default_rng(3)
    values = dict.fromkeys(NAMES, np.array([0.0, 0.0, 0.6, -0.4, 0.3, 0.0]))
    values["a"] = np.array([0.7, -0.3, 0.5, 0.9, 0.0, 0.0])
    compared = 0
    for _ in range(600):
        text = random_formula(rng, 4)
        formula = None if "1e" in text else read_or_none(text)  # differences see no 1e-30
        if formula is None:
            continue
        defined = np.isfinite(formula.evaluate(**values))
        found = np.where(defined, slope(formula, values, "a"), np.full(6, np.nan))
        for step in (1e-4, -1e-4):
            difference = one_sided(formula, values, step)
            both = np.isfinite(found) & np.isfinite(difference) & (np.abs(difference) < 100)
            np.testing.assert_allclose(
                found[both], difference[both], rtol=1e-3, atol=1e-3, err_msg=text
            )
            compared += np.count_nonzero(both)
    assert compared > 1000


def test_damaged_formulas_run_or_are_refused_with_their_place():
    rng = np.random.default_rng(0)
    letters = list("aβbx0123456789.+-*/()[]{}_,;:'\"\\ \n\x00eEjπ#@!%^&|~<>=`$?")
    for _ in range(400):
        text = list(FORMULAS[rng.integers(len(FORMULAS))])
        for _ in range(rng.integers(1, 6)):
            place = rng.integers(len(text))
            text[place : place + rng.integers(2)] = rng.choice(letters)
        formula = read_or_none("".join(text))
        if formula is not None:
            formula.evaluate(a=1.0, b=2.0, x=0.5, h0=1.0)
