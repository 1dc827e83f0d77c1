"""How a study reaches the rules: a file named to Snakemake, or a mapping from another workflow."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from squeezefilm.io.errors import InputError
from squeezefilm.studies.config import parse_config
from squeezefilm.studies.effective import write_effective

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

    Commands read files, and so can a reader later. The study is checked as a file's is, and gets
    the same defaults. A measured profile's file counts from the working directory.
    Raises InputError naming the key that is wrong, or a file that cannot be written.
    """
    place = Path("the module's config")
    if not values:
        raise InputError(f"{place}: there is none; it must be a study (config/README.md)")
    try:
        # Plain mappings without shared parts; what YAML read as the text 1e-6 is a number again.
        text = yaml.safe_dump(json.loads(json.dumps(values)), allow_unicode=True)
    except (TypeError, ValueError) as error:
        raise InputError(f"{place}: {error}") from None
    study = parse_config(text, path=place)
    return write_effective(study, results / study["study"])
