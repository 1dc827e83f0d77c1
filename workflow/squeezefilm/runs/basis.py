"""What the results of a command rest on, as a small file: ``results/STUDY/basis/``.

It lists the files that decide the command's numbers (code.py) and the sections of the study that it
reads, and is an input of every job that runs the command. Its name has the digest of its text, so
an edit gives the jobs another input, and an edit undone gives them back the one they had:

- Where Snakemake has its records, the inputs of a job are compared with those it had when it
  began. An edit while it runs is seen by the next run, whoever looked at the plan in between.
- Where it has none, as in a clone to which results were copied, times are compared. The file is
  copied with the results and older than they are; one that an edit brings is newer.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from squeezefilm.io.atomic import digest, write_text
from squeezefilm.runs.code import Code

DIGITS = 16


def basis_file(
    folder: Path,
    name: str,
    *,
    code: Code,
    files: Iterable[Path],
    sections: Mapping[str, Any],
    data: Iterable[Path] = (),
) -> Path:
    """The file for some code files, sections and data files; written unless it is there.

    Raises InputError where it cannot be written.
    """
    lines = [f"{path.relative_to(code.root)} {code.parts[path].digest}" for path in files]
    lines += [f"{path.name} {digest(path)}" for path in data]
    # Sorted, so that the order of keys in the study's file does not matter.
    lines += [f"{key} {json.dumps(_plain(v), sort_keys=True)}" for key, v in sections.items()]
    text = "\n".join(lines) + "\n"
    path = folder / f"{name}-{hashlib.sha256(text.encode()).hexdigest()[:DIGITS]}.txt"
    if not path.exists():
        write_text(text, path)
    return path


def _plain(value: Any) -> Any:
    """The same however a number was written: 43270, 43270.0 or 43.27 kHz."""
    if isinstance(value, Mapping):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, list):
        return [_plain(each) for each in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def forget_others(path: Path) -> None:
    """Remove what the command's results rested on before, as soon as they are made anew.

    Or an edit undone would find its file, older than the results of the edit.
    """
    name = path.stem[: -DIGITS - 1]
    for other in path.parent.glob(f"{name}-{'?' * DIGITS}.txt"):
        if other != path:
            other.unlink(missing_ok=True)
