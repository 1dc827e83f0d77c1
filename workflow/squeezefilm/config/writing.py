"""Writing a study down as it is computed: every key with its value and where that is from."""

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from squeezefilm.config.film import FilmSections
from squeezefilm.config.keys import Schema, schema_of_key, unit_of_schema
from squeezefilm.config.loading import validated_sections
from squeezefilm.config.study import Study
from squeezefilm.errors import InputError
from squeezefilm.files import read_text, write_text
from squeezefilm.sections import KeyPath

STUDY_FILE_NAME = "study.yaml"
"""The name of the file beside a study's results."""


def effective_yaml(config: FilmSections, *, folder: Path | None = None) -> str:
    """The whole study or film as YAML that reads as the same; what was not written says so.

    Args:
        folder: where the text will lie, for the paths of the files that the study names; by
            default beside the study.
    """
    sections = config.model_dump(exclude_none=True, by_alias=True)
    outline, measured = sections["pad"].get("outline", {}), sections.get("measurements", {})
    named = sections["actuator"]["profile"], outline, measured
    figures = sections.get("figures", {})
    for section, key in (*((model, "file") for model in named), (figures, "style")):
        if folder is not None and key in section:
            # ".." leads elsewhere from a folder that is a link.
            file = config.path.parent.resolve() / section[key]
            section[key] = os.path.relpath(file, start=folder.resolve())
    head = f"# {config.path}, all keys: values without a mark are written in that file.\n"
    return head + "".join(f"{line}\n" for line in _config_as_yaml_lines(sections, (), config))


def value_origin(config: FilmSections, key_path: KeyPath) -> str:
    """Origin of a key's value, as a text; empty where it was written."""
    if key_path in config.written_values:
        return ""
    words = _schema_of_config_key(config, key_path).get("derived")
    return f"derived: {words}" if words else "default"


def _schema_of_config_key(config: FilmSections, key_path: KeyPath) -> Schema:
    return schema_of_key(key_path, config.sections_as_dict())


def _config_as_yaml_lines(
    values: Mapping[str, Any], key_path: KeyPath, config: FilmSections
) -> Iterator[str]:
    for name, value in values.items():
        here = (*key_path, name)
        start = "  " * len(key_path) + f"{_yaml_on_one_line(name)}:"
        if isinstance(value, Mapping) and value:
            yield start
            yield from _config_as_yaml_lines(value, here, config)
        else:
            notes = unit_of_schema(_schema_of_config_key(config, here)), value_origin(config, here)
            note = ", ".join(filter(None, notes))
            yield f"{start} {_yaml_on_one_line(value)}" + (f" # {note}" if note else "")


def _yaml_on_one_line(value: Any) -> str:
    """A value on one line."""
    text = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=10**6)
    return text.removesuffix("\n").removesuffix("\n...")


def write_effective_study(config: Study, folder: Path) -> Path:
    """Write the whole study beside its results, unless it is there; the file's path.

    Raises InputError where it cannot be written.
    """
    path, text = folder / STUDY_FILE_NAME, effective_yaml(config, folder=folder)
    same = path.exists() and read_text(path, what="study") == text
    # Who runs the study of an earlier run reads that very file.
    if not same and path.resolve() != config.path.resolve():
        write_text(text, path)
    return path


def write_study_file(values: Mapping[str, Any], *, results: Path) -> Path:
    """The file of a study that another workflow gives as a mapping: ``results``/STUDY/study.yaml.

    Commands read files, and so can a reader later. The study is checked as a file's is, and gets
    the same defaults. A measured profile's file counts from the working directory.
    Raises InputError naming the key that is wrong, or a file that cannot be written.
    """
    source = Path("the module's config")
    if not values:
        raise InputError(f"{source}: none; it must be a study (docs/reference/configuration.md)")
    try:
        plain = json.loads(json.dumps(values))
    except (TypeError, ValueError) as error:
        raise InputError(f"{source}: {error}") from None
    study = validated_sections(plain, path=source, model=Study)
    return write_effective_study(study, results / study.study)
