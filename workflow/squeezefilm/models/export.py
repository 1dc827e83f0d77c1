"""A fitted model as source code without dependencies: a C header, a Python module, JavaScript.

A formula is printed once for all three, in brackets and with the functions of C's <math.h>; a
template of the language has the rest. Nothing of a fit's file gets into the code but numbers, the
checked formula, and names of letters, digits and underscores.
"""

import re
import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template

from squeezefilm.errors import InputError
from squeezefilm.formulas.expressions import Name, Node, Number
from squeezefilm.models.data import COLUMNS, FACTORS, POSITION
from squeezefilm.models.fit_file import FittedModel
from squeezefilm.models.limit_table import SLACK, LimitTable
from squeezefilm.solution import CARTESIAN, POLAR, form_of

FOLDER = Path(__file__).with_name("templates")
WIDTH, LARGEST = 96, 1e300
RADIANS_PER_DEGREE = "0.017453292519943295"
OTHER_FORM = {
    POLAR: {
        "phi_rad": f"(phi_deg * {RADIANS_PER_DEGREE})",
        "x_m": f"(phi_r_m * cos(phi_deg * {RADIANS_PER_DEGREE}))",
        "y_m": f"(phi_r_m * sin(phi_deg * {RADIANS_PER_DEGREE}))",
    },
    CARTESIAN: {
        "phi_r_m": "hypot(x_m, y_m)",
        "phi_deg": f"(atan2(y_m, x_m) / {RADIANS_PER_DEGREE})",
    },
}
"""The position by a function's arguments where they have it in the other form."""
MEANING = {
    "h0_m": "mean gap, m",
    "hv_m": "amplitude at the profile's maximum, m",
    "x_m": "finger's centre along x, m",
    "y_m": "finger's centre along y, m",
    "phi_r_m": "distance of the finger's centre from the actuator's, m",
    "phi_deg": "direction of the finger's centre, degrees",
}


@dataclass(frozen=True)
class Language:
    """What templates do not say of a language.

    begins: a line of the comment on the model; own: what names of the code's own begin with; array:
    how a column's table is written.
    """

    begins: str
    own: str
    nan: str
    array: str


LANGUAGES = {
    "c": Language(" * ", "${name}_", "NAN", "static const double ${own}$column[] = {\n$values\n};"),
    "javascript": Language("// ", "_", "NaN", "const _$column = [\n$values\n];"),
    "python": Language("", "_", "math.nan", "_$column = (\n$values\n)"),
}


def source(fit: FittedModel, language: str) -> str:
    """The code of one of LANGUAGES for a fitted model.

    Raises InputError for another language, a model's name that cannot name a function, or a model
    of physics whose file has no table of it.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,39}", fit.model):
        raise InputError(
            f"{fit.place}: the model's name {fit.model!r} cannot name a function; it must be "
            "small letters, digits and _"
        )
    if language not in LANGUAGES:
        raise InputError(f"language {language!r}: unknown; allowed are {', '.join(LANGUAGES)}")
    written = LANGUAGES[language]
    arguments, interval = fit.force_model.factor_names, fit.interval
    own = Template(written.own).substitute(name=fit.model)
    error = None if interval is None else interval.error_95
    known = {**fit.ranges, **(interval.ranges if interval else {})}
    limits = [known.get(name, (-LARGEST, LARGEST)) for name in arguments]
    values: dict[str, object] = {
        "name": fit.model,
        "NAME": fit.model.upper(),
        "own": own,
        "about": _lines(_about(fit), written.begins),
        "meaning": _lines((f"  {each}: {MEANING[each]}" for each in arguments), written.begins),
        "arguments": ", ".join(arguments),
        "parameters": ", ".join(f"double {each}" for each in arguments),
        "unused": " ".join(f"(void){each};" for each in arguments),
        "theta": _wrapped(fit.theta or (0.0,)),
        "low": ", ".join(_number(low) for low, _ in limits),
        "high": ", ".join(_number(high) for _, high in limits),
        "error_constant": _number(error[0]) if error else written.nan,
        "error_share": _number(error[1]) if error else written.nan,
        "formula": _printed(fit.force_model.parsed.root, _names(fit, own), own),
    }
    text = (FOLDER / f"{language}.in").read_text(encoding="utf-8")
    model, _, table = text.partition("------ table\n")
    if fit.force_model.column_names:
        table = Template(table).substitute(values | _table(fit, written, own))
    else:
        table = ""
    return Template(model).substitute(values, table=table)


def _names(fit: FittedModel, own: str) -> dict[str, str]:
    """What stands in the code for each name of the formula."""
    model = fit.force_model
    form = POLAR if set(POLAR) <= set(model.factor_names) else CARTESIAN
    factors = {column: OTHER_FORM[form].get(column, column) for column in FACTORS.values()}
    names = {name: factors[column] for name, column in FACTORS.items()}
    names |= {name: f"theta[{index}]" for index, name in enumerate(model.parameter_names)}
    if model.column_names:
        table = _limit_table(fit)
        position = ", ".join(factors[axis] for axis in form_of(table.ranges))
        for name, column in COLUMNS.items():
            names[name] = f"{own}tabulated({own}{column}, h0_m, hv_m, {position})"
        names["sigma"] = f"({_number(table.sigma_h0_square_m2)} / (h0_m * h0_m))"
    return names


def _printed(part: Node, names: Mapping[str, str], own: str) -> str:
    """A part of a formula, everything in brackets so that no order is left open."""
    if isinstance(part, Number):
        return _number(part.value)
    if isinstance(part, Name):
        return names[part.name]
    inner = [_printed(argument, names, own) for argument in part.arguments]
    match part.operator:
        case "negative":
            return f"(-{inner[0]})"
        case "+" | "-" | "*" | "/":
            return f"({inner[0]} {part.operator} {inner[1]})"
    function = {"**": "pow", "abs": "fabs", "sinc": f"{own}sinc"}.get(part.operator, part.operator)
    return f"{function}({', '.join(inner)})"


def _limit_table(fit: FittedModel) -> LimitTable:
    if fit.limit_table is None:
        raise InputError(
            f"{fit.place}: the model {fit.model} uses the physics limit, which code without "
            "dependencies cannot solve for, and its file has no table of it"
        )
    return fit.limit_table


def _table(fit: FittedModel, written: Language, own: str) -> dict[str, object]:
    """The table of the limits: coefficients of the columns that the model uses, and its axes."""
    table, used = _limit_table(fit), fit.force_model.column_names
    axes = table.axes
    coefficients = (
        Template(written.array).substitute(own=own, column=name, values=_wrapped(flat))
        for name, flat in table.coefficients.items()
        if name in used
    )
    centre = SLACK * max(axes["phi_r_m"][1], 1e-300) if "phi_r_m" in axes else -LARGEST
    return {
        "coefficients": "\n".join(coefficients),
        "axes_low": ", ".join(_number(low) for low, _ in axes.values()),
        "axes_high": ", ".join(_number(high) for _, high in axes.values()),
        "centre": _number(centre),
        "slack": _number(SLACK),
        **dict(zip("abcd", table.shape, strict=True)),
    }


def _about(fit: FittedModel) -> list[str]:
    """What the code is, for its first comment."""
    model, digest = fit.force_model, str(fit.source.get("forces_sha256"))
    lines = [
        f"Mean force of a squeeze film by the model {fit.model}, in newtons.",
        "",
        *textwrap.wrap(f"Formula: {model.expression}", 90, subsequent_indent="  "),
        f"Parameters: {', '.join(model.parameter_names) or 'none'}",
        f"Fitted to {fit.points} points with a global error of {100 * fit.global_error:.3g} %.",
        *textwrap.wrap(fit.statement.replace("φ", "phi_"), 90),
    ]
    if re.fullmatch(r"[0-9a-f]{64}", digest):
        lines.append(f"Forces (SHA-256): {digest}")
    if fit.symmetry is not None and set(model.factor_names) & set(POSITION):
        text = f"{fit.symmetry.text} Bring a position there before you call."
        lines += textwrap.wrap(text, 90)
    if model.column_names:
        error = _limit_table(fit).largest_relative_error
        lines.append(f"The physics limit is tabulated; its largest relative error is {error:.1e}.")
    return lines


def _lines(lines: Iterable[str], begin: str) -> str:
    return "\n".join(f"{begin}{line}".rstrip() for line in lines)


def _number(value: float) -> str:
    """A number that reads back as the same double, in every language."""
    text = repr(float(value))
    return f"({text})" if text.startswith("-") else text


def _wrapped(values: Iterable[float]) -> str:
    """Numbers with commas, in lines of a page's width."""
    return textwrap.fill(
        " ".join(f"{_number(value)}," for value in values),
        WIDTH,
        initial_indent="    ",
        subsequent_indent="    ",
        break_on_hyphens=False,
        break_long_words=False,
    )
