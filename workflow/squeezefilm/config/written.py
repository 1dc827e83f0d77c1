"""A study written down as it is computed, and one that another workflow gives as a mapping."""

import argparse
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from squeezefilm.config.keys import Place, part_at, schema, unit_of
from squeezefilm.config.loading import Config, config_of
from squeezefilm.errors import InputError
from squeezefilm.files import write_text

NAME = "study.yaml"
"""Of the file beside a study's results."""
DEFAULT, DERIVED = "default", "derived"
OPTIONS = ("--configfile", "--configfiles")


def effective_text(config: Config, *, folder: Path | None = None) -> str:
    """The whole study as YAML that reads as the same study; what was not written says so.

    Args:
        folder: where the text will lie, for the paths of a scan and an outline; beside the study
            if left out.
    """
    assert config.model is not None
    sections = config.model.model_dump(exclude_none=True, by_alias=True)
    for named in (sections["actuator"]["profile"], sections["finger"].get("outline", {})):
        if folder is not None and "file" in named:
            named["file"] = os.path.relpath(config.path.parent / named["file"], start=folder)
    head = f"# {config.path}, as it is computed: what is not marked was written there.\n"
    return head + "".join(f"{line}\n" for line in _lines(sections, (), config))


def origin(config: Config, place: Place) -> str:
    """Where the value of a key comes from, in words; empty where it was written."""
    if place in config.written:
        return ""
    words = part_at(schema(), place, config.sections).get("derived")
    return f"{DERIVED}: {words}" if words else DEFAULT


def _lines(values: Mapping[str, Any], place: Place, config: Config) -> Iterator[str]:
    for name, value in values.items():
        here = (*place, name)
        start = "  " * len(place) + f"{_flow(name)}:"
        if isinstance(value, Mapping) and value:
            yield start
            yield from _lines(value, here, config)
        else:
            notes = unit_of(part_at(schema(), here, config.sections)), origin(config, here)
            note = ", ".join(filter(None, notes))
            yield f"{start} {_flow(value)}" + (f" # {note}" if note else "")


def _flow(value: Any) -> str:
    """A value on one line."""
    text = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=10**6)
    return text.removesuffix("\n").removesuffix("\n...")


def write_effective(config: Config, folder: Path) -> Path:
    """Write the whole study beside its results, unless it is there; the file's path.

    Raises InputError where it cannot be written.
    """
    path, text = folder / NAME, effective_text(config, folder=folder)
    try:
        same = path.exists() and path.read_text(encoding="utf-8") == text
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from None
    # Who runs the study of an earlier run reads that very file.
    if not same and path.resolve() != config.path.resolve():
        write_text(text, path)
    return path


def written_study(values: Mapping[str, Any], *, results: Path) -> Path:
    """The file of a study that another workflow gives as a mapping: ``results``/STUDY/study.yaml.

    Commands read files, and so can a reader later. The study is checked as a file's is, and gets
    the same defaults. A measured profile's file counts from the working directory.
    Raises InputError naming the key that is wrong, or a file that cannot be written.
    """
    place = Path("the module's config")
    if not values:
        raise InputError(f"{place}: there is none; it must be a study (config/README.md)")
    try:
        plain = json.loads(json.dumps(values))
    except (TypeError, ValueError) as error:
        raise InputError(f"{place}: {error}") from None
    study = config_of(plain, path=place)
    return write_effective(study, results / study["study"])


def configfiles_in(words: Sequence[str]) -> list[str]:
    """All files that a command line names as configurations.

    Snakemake keeps those of the last such option alone, without a word.
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument(*OPTIONS, nargs="*", action="extend", default=[], dest="files")
    files: list[str] = parser.parse_known_args(words)[0].files
    return files
