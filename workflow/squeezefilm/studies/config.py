"""Reading a study's configuration: one loader for the rules and for the command line."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from squeezefilm.io.atomic import read_text
from squeezefilm.io.errors import InputError, naming
from squeezefilm.io.positions import CARTESIAN, POLAR
from squeezefilm.studies.derived import ENDS, whole_gas, with_derived
from squeezefilm.studies.mistakes import mistakes
from squeezefilm.studies.schema import Part, filled, in_si, schema

FILM_SECTIONS = ("gas", "actuator", "finger", "solver", "outputs")
DEFAULT, DERIVED = "default", "derived"
LARGEST_INTEGER = 2**53
"""Integers up to here are the same number when they are used as a float."""

FARTHEST = 1.5
"""An amplitude at which an extrapolation is checked, over the screen's largest."""
SLACK = 1e-9


class _Loader(yaml.SafeLoader):
    """YAML's plain part: true and false, null, decimal numbers, text, lists and mappings.

    ``1e-6`` is a number here, and nothing else turns into one by surprise (YAML 1.1 reads 12:30
    as 750 and 010 as 8). A key may stand only once; anchors and merge keys are refused, so that a
    file is no larger than it looks.
    """

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            mark = self.peek_event().start_mark
            raise yaml.MarkedYAMLError(problem="aliases are not allowed", problem_mark=mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = []
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str):
                problem = f"the key {key!r} is not text"
            elif key == "<<":
                problem = "merge keys are not allowed"
            elif key in seen:
                problem = f"the key {key!r} stands twice"
            else:
                seen.append(key)
                continue
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=key_node.start_mark)
        return super().construct_mapping(node, deep)


_Loader.yaml_implicit_resolvers = {}
for _tag, _pattern, _first in (
    ("bool", r"true|false", "tf"),
    ("null", r"null|~|", ["n", "~", ""]),
    ("int", r"[-+]?(0|[1-9]\d*)", "-+0123456789"),
    ("float", r"[-+]?(\d+\.\d*|\.\d+|\d+(?=[eE]))([eE][-+]?\d+)?", "-+0123456789."),
    ("float", r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", "-+."),
):
    _Loader.add_implicit_resolver(
        f"tag:yaml.org,2002:{_tag}", re.compile(f"^(?:{_pattern})$"), list(_first)
    )


@dataclass(frozen=True)
class Config(Mapping[str, Any]):
    """The whole of one study, defaults included.

    ``origins`` names every key that was not written, by its dotted place, with DEFAULT or DERIVED.
    """

    path: Path
    sections: dict[str, Any]
    origins: dict[str, str] = field(default_factory=dict)

    def __getitem__(self, section: str) -> Any:
        return self.sections[section]

    def __iter__(self) -> Iterator[str]:
        return iter(self.sections)

    def __len__(self) -> int:
        return len(self.sections)


def load_config(path: Path | str) -> Config:
    """Read and validate a configuration file; what it lacks has its default.

    Raises InputError naming the file, the key, what is wrong with it and what is allowed.
    """
    path = Path(path)
    return parse_config(read_text(path, what="configuration file"), path=path)


def load_film(path: Path | str) -> Config:
    """Read the sections of a film from a configuration; others are not checked and may be missing.

    Raises InputError as ``load_config`` does.
    """
    known = schema()["properties"]
    text = read_text(Path(path), what="configuration file")
    values = {
        name: value
        for name, value in _values_of(text, path=Path(path)).items()
        if name in FILM_SECTIONS or name not in known
    }
    return Config(Path(path), parse_film(values, place=Path(path)))


def parse_config(text: str, *, path: Path) -> Config:
    """Validate the text of a configuration file, which is or will be at ``path``.

    Raises InputError as ``load_config`` does.
    """
    values = _checked(_values_of(text, path=path), schema(), path=path)
    with_defaults = filled(values, schema())
    defaults = _places(with_defaults)
    with naming(path):
        whole = with_derived(with_defaults)
    _check_relations(whole, path=path)
    origins = {
        place: DEFAULT if place in defaults else DERIVED
        for place in sorted(_places(whole) - _places(values))
    }
    return Config(path=path, sections=whole, origins=origins)


def _values_of(text: str, *, path: Path) -> dict[str, Any]:
    try:
        values = yaml.load(text, Loader=_Loader)
    except (yaml.YAMLError, ValueError) as error:
        raise InputError(f"{path}: not valid YAML: {_one_line(error)}") from None
    except RecursionError:
        raise InputError(f"{path}: nested too deeply") from None
    if not isinstance(values, dict):
        raise InputError(f"{path}: a configuration is a mapping of keys to values")
    return values


def parse_film(values: dict[str, Any], *, place: Path) -> dict[str, Any]:
    """The sections of a film, checked and filled with defaults as a file's are.

    Raises InputError naming the place, the key, what is wrong with it and what is allowed.
    """
    whole = schema()
    part = {
        **whole,
        "properties": {name: whole["properties"][name] for name in FILM_SECTIONS},
        "required": [name for name in whole["required"] if name in FILM_SECTIONS],
    }
    found = dict(filled(_checked(values, part, path=place), part))
    if "gas" in found:
        with naming(place):
            found["gas"] = whole_gas(found["gas"])
    if "actuator" in found:
        _check_surface(found["actuator"], path=place)
    return found


def _checked(values: dict[str, Any], part: Part, *, path: Path) -> dict[str, Any]:
    """Values in SI units, without a mistake."""
    _refuse_non_finite(values, path=path, place="")
    values = in_si(values, part)
    wrong = [f"{path}: {each}" for each in mistakes(values, part)]
    if wrong:
        raise InputError("\n".join(wrong))
    return values


def _places(values: Mapping[str, Any], place: str = "") -> set[str]:
    """Every key that has a value, by the names that lead to it with dots between."""
    found = set()
    for name, value in values.items():
        if isinstance(value, Mapping) and value:
            found |= _places(value, f"{place}{name}.")
        else:
            found.add(f"{place}{name}")
    return found


def _refuse_non_finite(value: Any, *, path: Path, place: str) -> None:
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"{path}: {place}: {value} is not a finite number")
    if isinstance(value, int) and abs(value) > LARGEST_INTEGER:
        raise InputError(f"{path}: {place}: the number has too many digits")
    items: Iterable[tuple[Any, Any]] = ()
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        items = enumerate(value)
    for key, entry in items:
        _refuse_non_finite(entry, path=path, place=f"{place}.{key}" if place else str(key))


def _check_relations(values: dict[str, Any], *, path: Path) -> None:
    """Refuse what a schema cannot: empty ranges, contact, a position twice."""
    for section in ("screen", "error_map"):
        for factor in ("h0_m", "hv_m"):
            levels = values[section][factor]
            if levels["start"] >= levels["stop"]:
                raise InputError(f"{path}: {section}.{factor}: start must be below stop")
        if values[section]["hv_m"]["stop"] >= values[section]["h0_m"]["start"]:
            raise InputError(
                f"{path}: {section}: the largest hv_m must stay below the smallest h0_m, "
                "or surface and finger touch"
            )
    if values["extrapolation"]["hv_m"] >= values["extrapolation"]["h0_m"]:
        raise InputError(
            f"{path}: extrapolation: hv_m must stay below h0_m, or surface and finger touch"
        )
    _check_film_is_thin(values, path=path)
    _check_space(values, path=path)
    _check_surface(values["actuator"], path=path)
    _check_positions(values, path=path)


def _check_film_is_thin(values: dict[str, Any], *, path: Path) -> None:
    """Refuse a gap over which the pressure of sound differs: no film equation holds there."""
    gas, h0_m = values["gas"], values["screen"]["h0_m"]["stop"]
    frequency_hz = values["actuator"]["frequency_hz"]
    square = gas["heat_capacity_ratio"] * gas["ambient_pressure_pa"] / gas["density_kg_per_m3"]
    wavelength_m = math.sqrt(square) / frequency_hz
    if h0_m > wavelength_m / (2 * math.pi):
        raise InputError(
            f"{path}: actuator.frequency_hz: at {frequency_hz:g} Hz sound in this gas is "
            f"{wavelength_m:.2g} m long, and over a gap of {h0_m:g} m (screen.h0_m) pressure is "
            f"not the same, as in a film; at most "
            f"{wavelength_m / (2 * math.pi * h0_m) * frequency_hz:.2g} Hz"
        )


def _check_surface(actuator: dict[str, Any], *, path: Path) -> None:
    """Refuse two surfaces or none, and an axis that a rectangle does not have."""
    if ("surface" in actuator) == ("surface_radius_m" in actuator):
        raise InputError(
            f"{path}: actuator: give surface_radius_m, of a disc, or surface, of a rectangle, "
            "and not both"
        )
    if "surface" in actuator and actuator["profile"].get("axisymmetric"):
        raise InputError(
            f"{path}: actuator.profile.axisymmetric: a rectangle has no axis; it must be false"
        )


def _check_positions(values: dict[str, Any], *, path: Path) -> None:
    """Refuse positions in a form that is not the surface's."""
    positions, disc = values["positions"], "surface_radius_m" in values["actuator"]
    factors, shape = (POLAR, "disc") if disc else (CARTESIAN, "rectangle")
    if positions.keys() - {"points"} != set(factors):
        raise InputError(
            f"{path}: positions: on a {shape} they are {' and '.join(factors)}; "
            f"the keys are {', '.join(positions.keys() - {'points'})}"
        )
    for factor in factors:
        if len(set(positions[factor])) < len(positions[factor]):
            raise InputError(f"{path}: positions.{factor}: a value stands twice")
        if not disc and max(positions[factor]) <= 0:
            raise InputError(
                f"{path}: positions.{factor}: a value must be above 0: the finger moves in x and y"
            )
    if not disc and values.get("paper"):
        raise InputError(f"{path}: paper: the paper's actuator is a disc; it must be false")


def _check_space(values: dict[str, Any], *, path: Path) -> None:
    """Refuse what lies outside the screen's ranges: there the models are fitted, and all plans lie.

    The check of an extrapolation may lie above them in amplitude, up to FARTHEST times the largest.
    """
    for factor, farthest in (("h0_m", 1.0), ("hv_m", FARTHEST)):
        low, high = (values["screen"][factor][end] for end in ENDS)
        for key, value, most in (
            *(
                (f"error_map.{factor}.{end}", values["error_map"][factor][end], high)
                for end in ENDS
            ),
            (f"extrapolation.{factor}", values["extrapolation"][factor], farthest * high),
        ):
            if not low * (1 - SLACK) <= value <= most * (1 + SLACK):
                raise InputError(
                    f"{path}: {key}: {value:g} does not suit screen.{factor}, {low:g} … {high:g}, "
                    f"where the models are fitted; it must lie from {low:g} to {most:g}"
                )


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
