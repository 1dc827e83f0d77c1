"""A fitted model as source code without dependencies: a C header, or a Python module.

The code computes what ExpressionModel.evaluate does, operation by operation. Nothing of a fit's
file gets into it but numbers, the checked formula, and names of letters, digits and underscores.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from string import Template

from squeezefilm.formulas.expressions import Name, Node, Number
from squeezefilm.io.errors import InputError
from squeezefilm.models.fitted import FittedModel
from squeezefilm.models.force_model import (
    CARTESIAN,
    COLUMNS,
    FACTORS,
    POLAR,
    POSITION,
    ExpressionModel,
)
from squeezefilm.models.limit_table import AXES, SLACK

TEMPLATES = Path(__file__).parent / "templates"
RADIANS_PER_DEGREE = 0.017453292519943295
WIDTH = 96
RATIO = "hv_m / h0_m"
MEANING = {
    "h0_m": "mean gap, m",
    "hv_m": "amplitude at the profile's maximum, m",
    "x_m": "finger's centre along x, m",
    "y_m": "finger's centre along y, m",
    "phi_r_m": "distance of the finger's centre from the actuator's, m",
    "phi_deg": "direction of the finger's centre, degrees",
}
SAME = ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "atan")


@dataclass(frozen=True)
class _Language:
    """What differs between the two: how functions, constants and definitions are written."""

    prefix: str
    """Before the names of functions of <math.h> or ``math``."""
    own: str
    """Before the names of our own functions."""
    power: str
    define: str
    end: str
    nan: str

    def formula(self, part: Node, names: Mapping[str, str]) -> str:
        """A part of a formula, everything in brackets so that no order is left open."""
        if isinstance(part, Number):
            return _number(part.value)
        if isinstance(part, Name):
            return names[part.name]
        inner = [self.formula(argument, names) for argument in part.arguments]
        match part.operator:
            case "negative":
                return f"(-{inner[0]})"
            case "**" if part.arguments[1] == Number(2.0):
                return f"{self.own}square({inner[0]})"
            case "**":
                return f"{self.power}({inner[0]}, {inner[1]})"
            case "+" | "-" | "*" | "/":
                return f"({inner[0]} {part.operator} {inner[1]})"
            case "sinc":
                return f"{self.own}sinc({inner[0]})"
            case "abs":
                return f"{self.prefix}fabs({inner[0]})"
        assert part.operator in SAME
        return f"{self.prefix}{part.operator}({inner[0]})"

    def definition(self, name: str, value: str) -> str:
        return f"    {self.define}{name} = {value}{self.end}"


def c_source(fit: FittedModel) -> str:
    """A C99 header with the function ``NAME_force_n``; needs nothing but <math.h>."""
    name = _checked_name(fit)
    language = _Language("", f"{name}_", "pow", "const double ", ";", "NAN")
    inside = (
        f"{column} >= {_number(low)} && {column} <= {_number(high)}"
        for column, (low, high) in _ranges(fit).items()
    )
    return _filled(
        "model.h.txt",
        **_common(fit, language, theta=f"{name}_theta", table="table.h.txt"),
        NAME=name.upper(),
        about=_lines(_about(fit), indent=" * "),
        arguments=", ".join(f"double {each}" for each in fit.force_model.factor_names),
        unused=" ".join(f"(void){each};" for each in fit.force_model.factor_names),
        inside="\n        && ".join(inside) or "1",
        meaning=_lines(_meaning(fit), indent=" *     "),
    )


def python_source(fit: FittedModel) -> str:
    """A Python module with the function ``force_n``; needs nothing but ``math``."""
    language = _Language("math.", "_", "_power", "", "", "math.nan")
    names = fit.force_model.factor_names
    ranges = (
        f'    "{column}": ({_number(low)}, {_number(high)}),'
        for column, (low, high) in _ranges(fit).items()
    )
    return _filled(
        "model.py.txt",
        **_common(fit, language, theta="THETA", table="table.py.txt"),
        about="\n".join(_about(fit)),
        arguments=", ".join(names),
        names=", ".join(names),
        point=", ".join(
            f'"{each}": {each}{" if h0_m else math.nan" if each == RATIO else ""}'
            for each in _ranges(fit)
        ),
        ranges="\n".join(ranges),
        meaning=_lines(_meaning(fit), indent="    "),
    )


def _common(fit: FittedModel, language: _Language, *, theta: str, table: str) -> dict[str, str]:
    """What fills both templates, each in its language."""
    model = fit.force_model
    parameters = {name: f"{theta}[{index}]" for index, name in enumerate(model.parameter_names)}
    before = _position(model, language)
    if model.column_names:
        before += _limits(fit, language)
    return {
        "name": fit.model,
        "theta": _wrapped(_number(value) for value in fit.theta or (0.0,)),
        "error": language.nan if isnan(fit.error_n) else _number(fit.error_n),
        "table": _table(fit, language, template=table) if model.column_names else "",
        "before": "".join(f"{line}\n" for line in before),
        "formula": language.formula(model.parsed.root, {**FACTORS, **COLUMNS, **parameters}),
    }


def _position(model: ExpressionModel, language: _Language) -> list[str]:
    """The forms of the position that are used beside the one that is given."""
    used, given = set(model.parsed.names), model.factor_names
    lines = []
    if set(POLAR) <= set(given):
        if used & {"angle", "x", "y"}:
            lines.append(language.definition("phi_rad", f"phi_deg * {RADIANS_PER_DEGREE!r}"))
        for axis, function in zip(CARTESIAN, ("cos", "sin"), strict=True):
            if axis[0] in used:
                value = f"phi_r_m * {language.prefix}{function}(phi_rad)"
                lines.append(language.definition(axis, value))
    elif model.column_names:
        angle = f"{language.prefix}atan2(y_m, x_m) / {RADIANS_PER_DEGREE!r}"
        lines.append(language.definition("phi_r_m", f"{language.prefix}hypot(x_m, y_m)"))
        lines.append(language.definition("phi_deg", angle))
    return lines


def _limits(fit: FittedModel, language: _Language) -> list[str]:
    """The physics limits at the point, from their table."""
    table = fit.limit_table
    own = language.own
    reach = SLACK * max(table.ranges["phi_r_m"][1], 1e-300)
    low_angle = table.ranges["phi_deg"][0]
    c = language.end == ";"
    close, angle = _number(reach), _number(low_angle)
    direction = (
        f"phi_r_m <= {close} ? {angle} : phi_deg"
        if c
        else f"{angle} if phi_r_m <= {close} else phi_deg"
    )
    places = []
    for axis in AXES:
        low, high = table.ranges[axis]
        value = "direction_deg" if axis == "phi_deg" else axis
        numbers = (high + low) / 2, (high - low) / 2, SLACK * max(abs(low), abs(high))
        places.append(f"{own}place({value}, {', '.join(map(_number, numbers))})")
    joined = ",\n        ".join(places)
    return [
        language.definition("epsilon_square", f"{own}square(hv_m / h0_m)"),
        language.definition("direction_deg", direction),
        f"    const double places[4] = {{\n        {joined},\n    }};"
        if c
        else f"    places = (\n        {joined},\n    )",
        *(
            language.definition(
                column,
                f"{own}tabulated({_table_name(fit, column, language)}, places) * epsilon_square",
            )
            for column in _tabulated_columns(fit)
        ),
        *(
            [language.definition("sigma", f"{_number(table.sigma_h0_square)} / {own}square(h0_m)")]
            if COLUMNS["sigma"] in fit.force_model.column_names
            else []
        ),
    ]


def _table(fit: FittedModel, language: _Language, *, template: str) -> str:
    coefficients = []
    opening, closing = ("[] = {", "};") if language.end else (" = (", ")")
    for column in _tabulated_columns(fit):
        name = _table_name(fit, column, language)
        values = _wrapped(_number(value) for value in fit.limit_table.coefficients[column].ravel())
        start = f"static const double {name}" if language.end else name
        coefficients.append(f"{start}{opening}\n{values}\n{closing}")
    shape = next(iter(fit.limit_table.coefficients.values())).shape
    sizes = {letter: str(size) for letter, size in zip("abcd", shape, strict=True)}
    return _filled(template, name=fit.model, coefficients="\n".join(coefficients), **sizes)


def _table_name(fit: FittedModel, column: str, language: _Language) -> str:
    return f"{fit.model}_{column}" if language.end else f"_{column.upper()}"


def _tabulated_columns(fit: FittedModel) -> list[str]:
    return [name for name in fit.force_model.column_names if name != COLUMNS["sigma"]]


def _ranges(fit: FittedModel) -> dict[str, tuple[float, float]]:
    """The ranges of the fitted points in each argument, and in RATIO where the file tells it."""
    names = fit.force_model.factor_names
    ranges = {name: fit.ranges[name] for name in names if name in fit.ranges}
    if fit.trust is not None and {"h0_m", "hv_m"} <= set(names):
        ranges[RATIO] = fit.trust.ranges["epsilon"]
    return ranges


def _checked_name(fit: FittedModel) -> str:
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,39}", fit.model):
        raise InputError(
            f"{fit.place}: the model's name {fit.model!r} cannot name a function; it must be "
            "small letters, digits and _"
        )
    return fit.model


def _about(fit: FittedModel) -> list[str]:
    """What the code is, for its first comment."""
    model = fit.force_model
    source = fit.values.get("source")
    digest = str(source.get("forces_sha256")) if isinstance(source, dict) else ""
    lines = [
        f"Mean force of a squeeze film by the model {_checked_name(fit)}, in newtons.",
        "",
        *textwrap.wrap(f"Formula: {model.expression}", 90, subsequent_indent="  "),
        f"Parameters: {', '.join(model.parameter_names) or 'none'}",
        f"Fitted to {fit.points} points with a global error of {100 * fit.global_error:.3g} %.",
    ]
    if fit.scan_error:
        share = f"{100 * fit.scan_error:.2g} %"
        text = f"The profile was measured: its scan leaves {share} of a force open, in addition."
        lines.append(text)
    if re.fullmatch(r"[0-9a-f]{64}", digest):
        lines.append(f"Forces (SHA-256): {digest}")
    if fit.directions is not None and set(model.factor_names) & set(POSITION):
        low, high = fit.directions.start_deg, fit.directions.stop_deg
        why = fit.directions.because.replace("°", " deg")
        text = (
            f"Positions are at directions of {low:g} to {high:g} deg, which stand for all: {why}."
        )
        lines += textwrap.wrap(f"{text} Bring a position there before you call.", 90)
    if model.column_names:
        error = fit.limit_table.error
        lines.append(f"The physics limit is tabulated; its largest relative error is {error:.1e}.")
    return lines


def _meaning(fit: FittedModel) -> list[str]:
    return [f"{name}: {MEANING[name]}" for name in fit.force_model.factor_names]


def _number(value: float) -> str:
    """A number that reads back as the same double, in C and in Python."""
    text = repr(float(value))
    return f"({text})" if text.startswith("-") else text


def _lines(lines: Iterable[str], *, indent: str) -> str:
    return "\n".join(f"{indent}{line}".rstrip() for line in lines)


def _wrapped(values: Iterable[str]) -> str:
    """Values with commas, in lines of a page's width."""
    return textwrap.fill(
        " ".join(f"{value}," for value in values),
        WIDTH,
        initial_indent="    ",
        subsequent_indent="    ",
        break_on_hyphens=False,
        break_long_words=False,
    )


def _filled(template: str, **values: str) -> str:
    text = (TEMPLATES / template).read_text(encoding="utf-8")
    return Template(text).substitute(values)
