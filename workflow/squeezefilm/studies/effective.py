"""A study as it is computed: every key with its value, and where that comes from, as YAML."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from squeezefilm.io.atomic import write_text
from squeezefilm.io.errors import InputError
from squeezefilm.studies.config import DERIVED, Config
from squeezefilm.studies.schema import part_at

NAME = "study.yaml"
"""Of the file beside a study's results."""


def effective_text(config: Config, *, folder: Path | None = None) -> str:
    """The whole study as YAML that reads as the same study; what was not written says so.

    Args:
        folder: where the text will lie, for the paths of a scan and an outline; beside the study
            if left out.
    """
    sections = dict(config)
    profile = sections["actuator"]["profile"]
    if folder is not None and profile["kind"] == "measured":
        path = os.path.relpath(config.path.parent / profile["file"], start=folder)
        sections["actuator"] = {**sections["actuator"], "profile": {**profile, "file": path}}
    if folder is not None and sections["finger"]["shape"] == "curve":
        finger = sections["finger"]
        path = os.path.relpath(config.path.parent / finger["outline"]["file"], start=folder)
        sections["finger"] = {**finger, "outline": {**finger["outline"], "file": path}}
    head = f"# {config.path}, as it is computed: what is not marked was written there.\n"
    return head + "".join(f"{line}\n" for line in _lines(sections, (), config))


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


def _lines(values: Mapping[str, Any], place: tuple[str, ...], config: Config) -> list[str]:
    lines = []
    for name, value in values.items():
        here = (*place, name)
        key = yaml.safe_dump(name, default_flow_style=True, allow_unicode=True).split("\n")[0]
        start = "  " * len(place) + f"{key}:"
        if isinstance(value, Mapping) and value:
            lines += [start, *_lines(value, here, config)]
            continue
        origin = config.origins.get(".".join(here), "")
        if origin == DERIVED:
            words = part_at(here, config.sections).get("derived")
            origin += f": {words}" if words else ""
        lines.append(f"{start} {_flow(value)}" + (f" # {origin}" if origin else ""))
    return lines


def _flow(value: Any) -> str:
    """A value on one line."""
    text = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=10**6)
    return text.removesuffix("\n").removesuffix("\n...")
