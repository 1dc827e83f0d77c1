"""A fitted model as source code without dependencies: a C header, a Python module, JavaScript.

The code computes what ExpressionModel.evaluate does, operation by operation. Nothing of a fit's
file gets into it but numbers, the checked formula, and names of letters, digits and underscores.
How a language is written says its file in ``languages``, found by being there.
"""

import re
import textwrap
from collections.abc import Iterable, Mapping
from pathlib import Path
from string import Template
from typing import Any

import yaml

from squeezefilm.formulas.expressions import Name, Node, Number
from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import CARTESIAN, POLAR
from squeezefilm.models.fitted import FittedModel
from squeezefilm.models.force_model import COLUMNS, FACTORS, POSITION
from squeezefilm.models.limit_table import SLACK

FOLDER = Path(__file__).with_name("languages")
LANGUAGES = tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))
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
FUNCTIONS = {"abs": "fabs"} | {
    name: name
    for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "atan")
}


def source(fit: FittedModel, language: str) -> str:
    """The code of one of LANGUAGES for a fitted model.

    Raises InputError for another language, or a model's name that cannot name a function.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,39}", fit.model):
        raise InputError(
            f"{fit.place}: the model's name {fit.model!r} cannot name a function; it must be "
            "small letters, digits and _"
        )
    if language not in LANGUAGES:
        raise InputError(f"language {language!r}: unknown; allowed are {', '.join(LANGUAGES)}")
    said = yaml.safe_load((FOLDER / f"{language}.yaml").read_text(encoding="utf-8"))
    return _Writer(fit, said).source()


class _Writer:
    """One fitted model and what the language's file says."""

    def __init__(self, fit: FittedModel, said: Mapping[str, Any]) -> None:
        self.fit, self.model, self.said = fit, fit.force_model, said

    def source(self) -> str:
        fit, model = self.fit, self.model
        parameters = {
            name: self.written("theta", index=index)
            for index, name in enumerate(model.parameter_names)
        }
        before, table = self.position(), ""
        if model.column_names:
            before, table = before + self.limits(), self.table()
        return self.written(
            "model",
            theta=_wrapped(fit.theta or (0.0,)),
            **self.error(),
            table=table,
            before="".join(f"{line}\n" for line in before),
            formula=self.formula(model.parsed.root, {**FACTORS, **COLUMNS, **parameters}),
            **{name: self.listed(**entry) for name, entry in self.said["lists"].items()},
        )

    def error(self) -> dict[str, str]:
        """The 95 % error: its constant part in newtons and its share of the force."""
        interval = self.fit.interval
        parts = None if interval is None else interval.error_95
        names = ("error_constant", "error_share")
        values = [self.said["nan"]] * 2 if parts is None else map(_number, parts)
        return dict(zip(names, values, strict=True))

    def written(self, key: str, **values: object) -> str:
        """One of the language's patterns, filled."""
        return self.filled(self.said[key], **values)

    def filled(self, pattern: str, **values: object) -> str:
        names = {"name": self.fit.model, "NAME": self.fit.model.upper()}
        return Template(pattern).substitute(names, **values)

    def own(self, function: str, *arguments: str) -> str:
        """A call of one of the code's own functions."""
        return f"{self.written('own')}{function}({', '.join(arguments)})"

    def call(self, function: str, argument: str) -> str:
        """A call of one of the language's functions."""
        own = self.said.get("functions", {})
        return self.written("call", function=own.get(function, function), argument=argument)

    def define(self, variable: str, value: str) -> str:
        return self.written("definition", variable=variable, value=value)

    def listed(self, *, of: str, each: str, between: str, none: str = "") -> str:
        """A pattern for each line about the code, argument, or range of the fitted points."""
        names = self.model.factor_names
        items: Mapping[str, Iterable[dict[str, str]]] = {
            "about": ({"line": line} for line in _about(self.fit)),
            "arguments": ({"argument": name, "meaning": MEANING[name]} for name in names),
            "ranges": (
                {
                    "quantity": name,
                    "low": _number(low),
                    "high": _number(high),
                }
                for name, (low, high) in self.ranges().items()
            ),
        }
        return between.join(self.filled(each, **item).rstrip() for item in items[of]) or none

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
                return self.own("square", inner[0])
            case "**":
                return f"{self.said['power']}({inner[0]}, {inner[1]})"
            case "+" | "-" | "*" | "/":
                return f"({inner[0]} {part.operator} {inner[1]})"
            case "sinc":
                return self.own("sinc", inner[0])
        return self.call(FUNCTIONS[part.operator], inner[0])

    def position(self) -> list[str]:
        """The forms of the position that are used beside the one that is given."""
        used, given = set(self.model.parsed.names), self.model.factor_names
        lines = []
        if set(POLAR) <= set(given):
            if used & {"angle", "x", "y"}:
                lines.append(self.define("phi_rad", f"phi_deg * {RADIANS_PER_DEGREE!r}"))
            for axis, function in zip(CARTESIAN, ("cos", "sin"), strict=True):
                if axis[0] in used:
                    lines.append(self.define(axis, f"phi_r_m * {self.call(function, 'phi_rad')}"))
        elif self.model.column_names and "phi_deg" in self.fit.limit_table.ranges:
            angle = f"{self.call('atan2', 'y_m, x_m')} / {RADIANS_PER_DEGREE!r}"
            lines.append(self.define("phi_r_m", self.call("hypot", "x_m, y_m")))
            lines.append(self.define("phi_deg", angle))
        return lines

    def limits(self) -> list[str]:
        """The physics limits at the point, from their table."""
        table = self.fit.limit_table
        places = []
        for axis in table.ranges:
            low, high = table.ranges[axis]
            value = "direction_deg" if axis == "phi_deg" else axis
            numbers = (high + low) / 2, (high - low) / 2, SLACK * max(abs(low), abs(high))
            places.append(self.own("place", value, *map(_number, numbers)))
        lines = [self.define("epsilon_square", self.own("square", RATIO))]
        if "phi_deg" in table.ranges:
            reach = SLACK * max(table.ranges["phi_r_m"][1], 1e-300)
            direction = self.written(
                "choice",
                condition=f"phi_r_m <= {_number(reach)}",
                yes=_number(table.ranges["phi_deg"][0]),
                no="phi_deg",
            )
            lines.append(self.define("direction_deg", direction))
        lines += [
            self.written("places", places=",\n        ".join(places)),
        ]
        for column in self.tabulated():
            value = self.own("tabulated", self.column(column), "places")
            lines.append(self.define(column, f"{value} * epsilon_square"))
        if COLUMNS["sigma"] in self.model.column_names:
            value = f"{_number(table.sigma_h0_square)} / {self.own('square', 'h0_m')}"
            lines.append(self.define("sigma", value))
        return lines

    def table(self) -> str:
        """The table of the limits, and the functions that read it."""
        known = self.fit.limit_table.coefficients
        coefficients = (
            self.written("coefficients", table=self.column(name), values=_wrapped(known[name].flat))
            for name in self.tabulated()
        )
        sizes = dict(zip("abcd", next(iter(known.values())).shape, strict=True))
        return self.written("table", coefficients="\n".join(coefficients), **sizes)

    def column(self, name: str) -> str:
        """What the code calls a column's table."""
        return self.written("column", column=name, COLUMN=name.upper())

    def tabulated(self) -> list[str]:
        return [name for name in self.model.column_names if name != COLUMNS["sigma"]]

    def ranges(self) -> dict[str, tuple[float, float]]:
        """Of the declared space in each argument; of the fitted points where there is none."""
        interval = self.fit.interval
        known = {**self.fit.ranges, **(interval.ranges if interval else {})}
        return {name: known[name] for name in self.model.factor_names if name in known}


def _about(fit: FittedModel) -> list[str]:
    """What the code is, for its first comment."""
    model = fit.force_model
    source = fit.values.get("source")
    digest = str(source.get("forces_sha256")) if isinstance(source, dict) else ""
    lines = [
        f"Mean force of a squeeze film by the model {fit.model}, in newtons.",
        "",
        *textwrap.wrap(f"Formula: {model.expression}", 90, subsequent_indent="  "),
        f"Parameters: {', '.join(model.parameter_names) or 'none'}",
        f"Fitted to {fit.points} points with a global error of {100 * fit.global_error:.3g} %.",
    ]
    lines += textwrap.wrap(fit.statement.replace("φ", "phi_"), 90)
    if re.fullmatch(r"[0-9a-f]{64}", digest):
        lines.append(f"Forces (SHA-256): {digest}")
    if fit.symmetry is not None and set(model.factor_names) & set(POSITION):
        text = f"{fit.symmetry.text} Bring a position there before you call."
        lines += textwrap.wrap(text, 90)
    if model.column_names:
        error = fit.limit_table.error
        lines.append(f"The physics limit is tabulated; its largest relative error is {error:.1e}.")
    return lines


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
