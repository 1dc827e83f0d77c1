"""A study that the workflow can rely on: read, checked and divided into jobs once.

A scan is smoothed and the solver is asked what scenes cost for it, which takes longer than all else
that a run with nothing to do does. So what was found is kept, until the study's file, its scan, its
outline, or the code that checks is another one. A study that is refused is never kept.
"""

import hashlib
import json
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from squeezefilm.io.atomic import digest, write_text
from squeezefilm.io.errors import InputError
from squeezefilm.io.job import remembered
from squeezefilm.runs.code import Code
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.schema import SCHEMA_PATH

FILES = ("scan", "outline")
CHECKS = ("squeezefilm.studies.study", "squeezefilm.studies.chunks", "squeezefilm.models.library")


@dataclass(frozen=True)
class CheckedStudy:
    """A study's configuration, its number of jobs by plan, and the files that it rests on.

    Attributes:
        scan: that its vibration was measured in, if it was.
        outline: that of its finger's outline, if there is one.
    """

    config: Config
    chunks: dict[str, int]
    scan: Path | None
    outline: Path | None


def checked_study(path: Path, *, code: Code, memory: Path) -> CheckedStudy:
    """The study of a file; ``memory`` is a folder that keeps what was found.

    Raises InputError naming the file, the key, what is wrong with it and what is allowed.
    """
    kept = memory / f"study-{hashlib.sha256(str(path).encode()).hexdigest()[:16]}.json"
    known = remembered(kept)
    files = {name: Path(known[name]) if known.get(name) else None for name in FILES}
    if known.get("key") and known["key"] == _key(path, files.values(), code):
        config = Config(path, known["sections"], known["origins"])
        return CheckedStudy(config, known["chunks"], **files)
    study = _check(path)
    known = {
        "key": _key(path, (study.scan, study.outline), code),
        "sections": study.config.sections,
        "origins": study.config.origins,
        "chunks": study.chunks,
        "scan": study.scan and str(study.scan),
        "outline": study.outline and str(study.outline),
    }
    with suppress(InputError):
        write_text(json.dumps(known), kept)
    return study


def _check(path: Path) -> CheckedStudy:
    from squeezefilm.models.library import check_models
    from squeezefilm.studies.chunks import chunk_counts
    from squeezefilm.studies.study import check_study, outline_path, scan_path

    config = check_study(load_config(path))
    check_models(config["models"], config, place=path)
    return CheckedStudy(config, chunk_counts(config), scan_path(config), outline_path(config))


def _key(path: Path, files: Iterable[Path | None], code: Code) -> str | None:
    """A digest of all that the checks rest on; None where a file cannot be read."""
    together = hashlib.sha256()
    try:
        for file in (path, SCHEMA_PATH, *filter(None, files)):
            together.update(digest(file).encode())
    except OSError:
        return None
    for file in code.reached_from(*CHECKS):
        together.update(code.parts[file].digest.encode())
    return together.hexdigest()
