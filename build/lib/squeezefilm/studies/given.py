"""How a study reaches the rules: a file named to Snakemake, or a mapping from another workflow."""

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from squeezefilm.io.atomic import write_text
from squeezefilm.io.errors import InputError
from squeezefilm.studies.config import parse_config

OPTIONS = ("--configfile", "--configfiles")


def configfiles_in(words: Sequence[str]) -> list[str]:
    """All files that a command line names as configurations.

    Snakemake keeps those of the last such option alone, without a word.
    """
    files, taking = [], False
    for word in words:
        option, _, value = word.partition("=")
        if option in OPTIONS:
            files += [value] if value else []
            taking = not value
        elif word.startswith("-"):
            taking = False
        elif taking:
            files.append(word)
    return files


def written_study(values: Mapping[str, Any], *, results: Path) -> Path:
    """The file of a study that another workflow gives as a mapping: ``results``/STUDY/study.yaml.

    Commands read files, and so can a reader later. The study is checked as a file's is, and whole:
    nothing is added to it. A measured profile's file counts from the working directory.
    Raises InputError naming the key that is wrong, or a file that cannot be written.
    """
    place = Path("the module's config")
    if not values:
        raise InputError(f"{place}: there is none; it must be a whole study (config/README.md)")
    try:
        # Plain mappings without shared parts; what YAML read as the text 1e-6 is a number again.
        study = json.loads(json.dumps(values))
    except (TypeError, ValueError) as error:
        raise InputError(f"{place}: {error}") from None
    folder = results / parse_config(_text(study), path=place)["study"]
    profile = study["actuator"]["profile"]
    if profile["kind"] == "measured":
        profile["file"] = os.path.relpath(profile["file"], start=folder)
    path, text = folder / "study.yaml", _text(study)
    try:
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            folder.mkdir(parents=True, exist_ok=True)
            write_text(text, path)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be written: {error}") from None
    return path


def _text(study: Any) -> str:
    return yaml.safe_dump(study, sort_keys=False, allow_unicode=True)
