"""A fitted model as source code without dependencies: a C header, Python, JavaScript, MATLAB.

A formula is printed once for all of them, in brackets and with the functions of C's <math.h>; a
template of the language has the rest. Nothing of a fit's file gets into the code but numbers, the
checked formula, and names of letters, digits and underscores.
"""

import re
import textwrap
from collections.abc import Iterable, Mapping
from pathlib import Path
from string import Template

from squeezefilm.columns import COLUMNS
from squeezefilm.errors import InputError
from squeezefilm.film.positions import CARTESIAN_COLUMNS, POLAR_COLUMNS, find_position_columns
from squeezefilm.film.symmetry import MirrorAxes
from squeezefilm.formulas import Expression, Operation, fold_formula
from squeezefilm.models.data import (
    FACTOR_COLUMN_OF_NAME,
    PHYSICS_COLUMN_OF_NAME,
    POSITION_COLUMNS,
    RANGE_TOLERANCE,
)
from squeezefilm.models.fit_file import FittedModel
from squeezefilm.models.force_model import ExpressionModel
from squeezefilm.models.limit_table import LimitTable

TEMPLATES_FOLDER = Path(__file__).with_name("templates")
CODE_LINE_WIDTH, MAX_FINITE_LIMIT = 92, 1e300
RADIANS_PER_DEGREE_LITERAL = "0.017453292519943295"
OTHER_POSITION_EXPRESSIONS = {
    POLAR_COLUMNS: {
        "phi_rad": f"(phi_deg * {RADIANS_PER_DEGREE_LITERAL})",
        "x_m": f"(phi_r_m * cos(phi_deg * {RADIANS_PER_DEGREE_LITERAL}))",
        "y_m": f"(phi_r_m * sin(phi_deg * {RADIANS_PER_DEGREE_LITERAL}))",
    },
    CARTESIAN_COLUMNS: {
        "phi_r_m": "hypot(x_m, y_m)",
        "phi_deg": f"(atan2(y_m, x_m) / {RADIANS_PER_DEGREE_LITERAL})",
    },
}
"""The position by a function's arguments where they have it in the other form."""
NAN_OF_LANGUAGE = {"c": "NAN", "javascript": "NaN", "matlab": "NaN", "python": "math.nan"}
"""And what a number that is none is called."""
STATEMENT_END = {"c": ";\n    ", "javascript": ";\n  ", "matlab": ";\n", "python": "\n    "}
VARIABLE_DECLARATION = {"c": "const double ", "javascript": "const "}
"""How a statement ends, with the next line's indentation, and how a name of its own begins."""
PRIVATE_NAME_PREFIX = {"c": "{name}_", "matlab": "own_"}
"""How names begin that only the code itself uses, if not with _."""
FUNCTIONS_WITH_REAL_WRAPPER = {"matlab": ("sqrt", "log")}
"""Functions that are complex where they have no real value: the code has its own."""


def source_code(fit: FittedModel, language: str, *, name: str = "") -> str:
    """The code of one of NAN_OF_LANGUAGE for a fitted model.

    Positions are brought to those that stand for all others by the study's symmetry, as the
    library does it.

    Args:
        name: of the function in MATLAB, which is that of its file; by default the model's.

    Raises InputError for another language, a model's name that cannot name a function, or a model
    of physics whose file has no table of it.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,39}", fit.model):
        raise InputError(
            f"{fit.file}: the model's name {fit.model!r} cannot name a function; it must be "
            "small letters, digits and _"
        )
    if name and not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name):
        raise InputError(f"{name}: cannot name a function; use letters, digits and _")
    if language not in NAN_OF_LANGUAGE:
        raise InputError(
            f"language {language!r}: unknown; allowed are {', '.join(NAN_OF_LANGUAGE)}"
        )
    model, interval, table = fit.force_model, fit.prediction_interval, fit.required_asymptote_table
    arguments, nan = model.factor_names, NAN_OF_LANGUAGE[language]
    own = PRIVATE_NAME_PREFIX.get(language, "_").format(name=fit.model)
    names = _names_in_code(model, table, own)
    if language == "matlab":  # it counts from 1
        for index, parameter in enumerate(model.parameter_names, start=1):
            names[parameter] = f"theta({index})"
    error = interval.error_95 if interval else None
    constant, relative = map(_number_literal, error) if error else (nan, nan)
    space = interval.ranges if interval else fit.ranges
    point = _factor_expressions_of_space(model, space)
    values: dict[str, object] = {
        "name": name or fit.model,
        "NAME": fit.model.upper(),
        "own": own,
        "about": "\n".join(_code_description(fit, table)),
        "meaning": "\n".join(f"    {name}: {COLUMNS[name].label}" for name in arguments),
        "arguments": ", ".join(arguments),
        "parameters": ", ".join(f"double {name}" for name in arguments),
        "unused": " ".join(f"(void){name};" for name in arguments),
        "theta": _wrapped_numbers(fit.theta or (0.0,), language),
        "limited": ", ".join(point),
        "point": ", ".join(point.values()),
        "low": ", ".join(_number_literal(space[name][0]) for name in point),
        "high": ", ".join(_number_literal(space[name][1]) for name in point),
        "slack": _number_literal(RANGE_TOLERANCE),
        "fold": "".join(
            f"{line}{STATEMENT_END[language]}" for line in _position_folding_code(fit, language)
        ),
        "error_constant": constant,
        "error_share": relative,
        "formula": _bracketed_formula(
            model.parsed_expression, names, own, FUNCTIONS_WITH_REAL_WRAPPER.get(language, ())
        ),
    }
    text = (TEMPLATES_FOLDER / f"{language}.in").read_text(encoding="utf-8")
    code, sinc, tabulated, column = map(Template, re.split("------ .*\n", text))
    used = f"{own}sinc(" in str(values["formula"])
    values["sinc"] = sinc.substitute(own=own) if used else ""
    if table is None:
        return code.substitute(values, table="")
    columns = "\n".join(
        column.substitute(own=own, column=name, values=_wrapped_numbers(flat, language)).strip()
        for name, flat in table.coefficients.items()
        if name in model.column_names
    )
    axes = table.axis_levels.values()
    position = table.axis_levels.get("phi_r_m")
    in_table = {
        "coefficients": columns,
        "axes_low": ", ".join(_number_literal(low) for low, _ in axes),
        "axes_high": ", ".join(_number_literal(high) for _, high in axes),
        "centre": _number_literal(
            RANGE_TOLERANCE * max(position[1], 1e-300) if position else -MAX_FINITE_LIMIT
        ),
        **dict(zip("abcd", table.shape, strict=True)),
    }
    return code.substitute(values, table=tabulated.substitute(values, **in_table))


def _factor_expressions(model: ExpressionModel) -> dict[str, str]:
    """Expressions of all factors in a function's arguments, by their columns."""
    form = POLAR_COLUMNS if set(POLAR_COLUMNS) <= set(model.factor_names) else CARTESIAN_COLUMNS
    return {
        column: OTHER_POSITION_EXPRESSIONS[form].get(column, column)
        for column in FACTOR_COLUMN_OF_NAME.values()
    }


def _position_folding_code(fit: FittedModel, language: str) -> list[str]:
    """Statements that bring a function's position to the one that stands for it."""
    symmetry, arguments = fit.symmetry, fit.force_model.factor_names
    polar, cartesian = (set(form) <= set(arguments) for form in (POLAR_COLUMNS, CARTESIAN_COLUMNS))
    if symmetry is None or not (polar or cartesian):
        return []
    other = OTHER_POSITION_EXPRESSIONS[POLAR_COLUMNS if polar else CARTESIAN_COLUMNS]
    r, phi = (other.get(name, name) for name in POLAR_COLUMNS)
    if isinstance(symmetry, MirrorAxes):
        mirrored = {
            name for name, on in zip(CARTESIAN_COLUMNS, (symmetry.x, symmetry.y), strict=True) if on
        }
        if cartesian:
            return [f"{name} = fabs({name})" for name in CARTESIAN_COLUMNS if name in mirrored]
        x, y = (
            f"fabs({other[name]})" if name in mirrored else other[name]
            for name in CARTESIAN_COLUMNS
        )
        return [f"phi_deg = (atan2({y}, {x}) / {RADIANS_PER_DEGREE_LITERAL})"]
    start, width = _number_literal(symmetry.start_deg), _number_literal(symmetry.width_deg)
    period = _number_literal(symmetry.width_deg * (2 if symmetry.mirror else 1))
    angle = f"({phi} - {start})"
    folded = f"({angle} - {period} * floor({angle} / {period}))"
    if symmetry.mirror:
        folded = f"({width} - fabs({folded} - {width}))"
    if polar:  # at the centre every direction is the same
        return [f"phi_deg = phi_deg + (phi_r_m > 0) * ({start} + {folded} - phi_deg)"]
    declared = VARIABLE_DECLARATION.get(language, "")
    return [
        f"{declared}folded_r_m = {r}",
        f"{declared}folded_rad = ({start} + {folded}) * {RADIANS_PER_DEGREE_LITERAL}",
        "x_m = folded_r_m * cos(folded_rad)",
        "y_m = folded_r_m * sin(folded_rad)",
    ]


def _factor_expressions_of_space(
    model: ExpressionModel, space: Mapping[str, tuple[float, float]]
) -> dict[str, str]:
    """Expressions of the factors that a space limits, by their columns.

    Without the position of a model of the centred pad. At the centre all directions are the same.
    """
    factors, centred = _factor_expressions(model), model.factor_names[2:] == ()
    point = {name: factors[name] for name in space if not (centred and name in POSITION_COLUMNS)}
    low, high = space.get("phi_deg", (1.0, -1.0))
    if "phi_deg" in point and low <= 0 <= high:
        off_centre = (
            f"({point['phi_r_m']} > {_number_literal(RANGE_TOLERANCE * space['phi_r_m'][1])})"
        )
        point["phi_deg"] = f"({point['phi_deg']} * {off_centre})"
    return point


def _names_in_code(model: ExpressionModel, table: LimitTable | None, own: str) -> dict[str, str]:
    """Names in the code for the names of the formula."""
    factors = _factor_expressions(model)
    names = {name: factors[column] for name, column in FACTOR_COLUMN_OF_NAME.items()}
    names |= {name: f"theta[{index}]" for index, name in enumerate(model.parameter_names)}
    if table is not None:
        position = ", ".join(factors[axis] for axis in find_position_columns(table.ranges))
        for name, column in PHYSICS_COLUMN_OF_NAME.items():
            names[name] = f"{own}tabulated({own}{column}, h0_m, hv_m, {position})"
        names["sigma"] = f"({_number_literal(table.sigma_h0_square_m2)} / (h0_m * h0_m))"
    return names


def _bracketed_formula(
    expression: Expression, names: Mapping[str, str], own: str, real: Iterable[str]
) -> str:
    """A formula with everything in brackets, so that the order is explicit."""
    other = {"**": "pow", "abs": "fabs", "sinc": f"{own}sinc", **{f: f"{own}{f}" for f in real}}

    def operation_code(part: Operation, arguments: list[str]) -> str:
        if part.operator == "negative":
            return f"(-{arguments[0]})"
        if part.operator in "+-*/":
            return f"({arguments[0]} {part.operator} {arguments[1]})"
        return f"{other.get(part.operator, part.operator)}({', '.join(arguments)})"

    return fold_formula(
        expression.root,
        lambda leaf: _number_literal(leaf) if leaf not in names else names[leaf],
        operation_code,
    )


def _code_description(fit: FittedModel, table: LimitTable | None) -> list[str]:
    """Description of the code, for its first comment."""
    model, digest = fit.force_model, str(fit.source.get("forces_sha256"))
    lines = [
        f"Mean force of a squeeze film by the model {fit.model}, in newtons.",
        "",
        *textwrap.wrap(f"Formula: {model.formula_text}", 90, subsequent_indent="  "),
        f"Parameters: {', '.join(model.parameter_names) or 'none'}",
        f"Fitted to {fit.points} points with a global error of {100 * fit.global_error:.3g} %.",
        *textwrap.wrap(fit.statement.replace("φ", "phi"), 90),
    ]
    if re.fullmatch(r"[0-9a-f]{64}", digest):
        lines.append(f"Forces (SHA-256): {digest}")
    if fit.symmetry is not None and set(model.factor_names) & set(POSITION_COLUMNS):
        lines += textwrap.wrap(f"{fit.symmetry.text} The code does this.", 90)
    if table is not None:
        error = table.largest_relative_error
        lines.append(f"The expansion is tabulated; its largest relative error is {error:.1e}.")
    return lines


def _number_literal(value: float) -> str:
    """A number that reads back as the same double, in every language."""
    text = repr(float(value))
    return f"({text})" if text.startswith("-") else text


def _wrapped_numbers(values: Iterable[float], language: str) -> str:
    """Numbers with commas, in lines of a page's width, which MATLAB wants to be told to go on."""
    text = " ".join(f"{_number_literal(value)}," for value in values)
    lines = textwrap.wrap(text, CODE_LINE_WIDTH, break_on_hyphens=False, break_long_words=False)
    if language != "matlab":
        return textwrap.indent("\n".join(lines), "    ")
    return textwrap.indent(" ...\n".join(lines), "    ").rstrip(",")
