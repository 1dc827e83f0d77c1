"""Reading a study from YAML: all that is wrong with it at once, each with its line and remedy."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Mapping
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import yaml
from pydantic import ValidationError

from squeezefilm.config.film import FilmSections
from squeezefilm.errors import InputError
from squeezefilm.files import read_text
from squeezefilm.sections import KeyPath
from squeezefilm.units import DECIMAL_REGEX

if TYPE_CHECKING:
    from squeezefilm.config.study import Study

FilmSectionsT = TypeVar("FilmSectionsT", bound=FilmSections)

CONFIGURATION_FILE_LABEL = "configuration file"
YAML_LITERALS = {"true": True, "false": False, "null": None, "~": None, "": None}
INTEGER_PATTERN = re.compile(r"[-+]?(?:0|[1-9]\d*)", re.ASCII)
FLOAT_PATTERN = re.compile(
    rf"(?!{INTEGER_PATTERN.pattern}$)(?!0\d){DECIMAL_REGEX}|[-+]?\.(?:inf|nan)", re.I | re.ASCII
)
MAX_INTEGER_DIGITS = 18
PLAN_SECTION_NAMES = ("screen", "extrapolation")
"""Sections that a study needs beside its film."""
STUDY_SECTION_NAMES = (
    *("study", "paper", *PLAN_SECTION_NAMES, "error_map", "positions", "sweep", "simulation"),
    *("fit", "models", "comparison", "refine", "validation", "design", "four_factor_design"),
    *("four_factor_control", "optimal", "numerics", "figures", "measurements"),
)
"""Keys of a study beside its film: models of them take as long to define as a small film."""


class FilmWithoutStudyError(InputError):
    """A file has a film and no plan, so that it is no study."""


def load_config(path: Path | str) -> Study:
    """Read and validate the file of a study; what it lacks has its default.

    Raises InputError naming the file, line and key, what is wrong with it and what is allowed;
    FilmWithoutStudyError for a film without a study.
    """
    return parse_config(read_text(path, what=CONFIGURATION_FILE_LABEL), path=Path(path))


def parse_config(text: str, *, path: Path) -> Study:
    """Validate the text of a study, which is or will be at ``path``.

    Raises InputError as ``load_config`` does.
    """
    from squeezefilm.config.study import Study

    values, lines = _read_yaml(text, path=path)
    if {"actuator", "pad"} <= {*values} and not {*PLAN_SECTION_NAMES} & {*values}:
        raise FilmWithoutStudyError(
            f"{path}: a film without a study: `squeezefilm simulate`, `levitate`, `profile` "
            "and, in Python, `sf.Film.read` take it; a study also has a name, study, and the "
            f"sections {' and '.join(PLAN_SECTION_NAMES)}"
        )
    return validated_sections(values, path=path, lines=lines, model=Study)


def load_film(path: Path | str) -> FilmSections:
    """Read the film of a study; sections that only a study has are not checked and may be missing.

    Raises InputError as ``load_config`` does.
    """
    path = Path(path)
    values, lines = _read_yaml(read_text(path, what=CONFIGURATION_FILE_LABEL), path=path)
    of_film = {name: values[name] for name in values if name not in STUDY_SECTION_NAMES}
    return validated_sections(of_film, path=path, lines=lines, model=FilmSections)


def validated_sections(
    values: Mapping[str, Any],
    *,
    path: Path,
    model: type[FilmSectionsT],
    lines: Mapping[KeyPath, int] | None = None,
) -> FilmSectionsT:
    """Validate sections by the keys of a file.

    Args:
        path: the file that they are of, or a name for where they are from.
        model: what they are to be, a study or its film.
        lines: of the file, at which keys and items stand.

    Raises InputError as ``load_config`` does.
    """
    try:
        return model.model_validate(values).with_source(path, values)
    except ValidationError as error:
        from squeezefilm.config.messages import messages_of_errors

        messages = messages_of_errors(error, values, lines or {})
        raise InputError("\n".join(f"{path}: {message}" for message in messages)) from None


def with_changed_keys(config: FilmSectionsT, changes: Mapping[str, Any]) -> FilmSectionsT:
    """The study with other values of some keys, which stand in a file as ``gas.viscosity`` does.

    Raises InputError as ``load_config`` does.
    """
    values = config.model_dump(exclude_none=True, by_alias=True)
    for key_path, value in changes.items():
        *sections, key = key_path.split(".")
        reduce(getitem, sections, values)[key] = value
    return validated_sections(values, path=config.path, model=type(config))


def _read_yaml(text: str, *, path: Path) -> tuple[dict[str, Any], dict[KeyPath, int]]:
    """The values of a YAML text, and the line of each.

    Of YAML its plain part: true, false, null, decimal numbers, text, lists and mappings, for YAML's
    own rules read 12:30 as 750 and 010 as 8. A key may stand only once, and no alias: a file is
    no larger than it looks.
    """
    lines: dict[KeyPath, int] = {}
    seen: set[yaml.Node] = set()

    def value_of_node(node: yaml.Node, key_path: KeyPath) -> Any:
        if node in seen:
            line = node.start_mark.line + 1
            raise InputError(f"{path}: line {line}: an alias of this value is not allowed")
        seen.add(node)
        lines.setdefault(key_path, node.start_mark.line + 1)
        if isinstance(node, yaml.SequenceNode):
            return [value_of_node(item, (*key_path, i)) for i, item in enumerate(node.value)]
        if isinstance(node, yaml.ScalarNode):
            return node.value if node.style else _parse_yaml_scalar(node.value)
        values: dict[str, Any] = {}
        for key, value in node.value:
            name, line = key.value, key.start_mark.line + 1
            if not isinstance(name, str) or name in values:
                what = "stands twice" if isinstance(name, str) else "is not text"
                raise InputError(f"{path}: line {line}: the key {reprlib.repr(name)} {what}")
            lines[*key_path, name] = line
            values[name] = value_of_node(value, (*key_path, name))
        return values

    try:
        # A base loader takes every scalar as text; that in C is ten times faster.
        node = yaml.compose(text, Loader=getattr(yaml, "CBaseLoader", yaml.BaseLoader))
        values = value_of_node(node, ()) if node else None
    except yaml.YAMLError as error:
        reason = " ".join(str(error).split()).replace('"<unicode string>", ', "")
        mark = getattr(error, "problem_mark", None)
        line = text.splitlines()[mark.line : mark.line + 1] if mark else []
        hint = "; indent by spaces: YAML allows no tab there" if "\t" in "".join(line) else ""
        raise InputError(f"{path}: not valid YAML: {reason}{hint}") from None
    except RecursionError:
        raise InputError(f"{path}: nested too deeply") from None
    if not isinstance(values, dict):
        raise InputError(f"{path}: a configuration is a mapping of keys to values")
    return values, lines


def _parse_yaml_scalar(text: str) -> Any:
    if text in YAML_LITERALS:
        return YAML_LITERALS[text]
    if INTEGER_PATTERN.fullmatch(text):
        return int(text) if len(text) <= MAX_INTEGER_DIGITS else float(text)
    return (
        float(text.replace(".i", "i").replace(".n", "n")) if FLOAT_PATTERN.fullmatch(text) else text
    )
