"""The runs that made a study's present results, on one page: code, settings, machines, files."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from squeezefilm.errors import InputError
from squeezefilm.pages.markdown import markdown_rows
from squeezefilm.runs.run_card import Made, made_files


def to_markdown(cards: Path) -> str:
    """The page, from a study's folder of run cards (see run_card.py).

    A run that is still going on is on it too, with the files that it has made so far.

    Raises:
        InputError: where no run has made a file.
    """
    made = {one.path: one for one in made_files(cards)}  # the newest of each name
    if not made:
        raise InputError(f"{cards}: no run has made a file of this study")
    runs: dict[str, list[Made]] = {}
    for one in made.values():
        runs.setdefault(one.run["run"], []).append(one)
    parts = ["# Runs that made these results\n"]
    for files in sorted(runs.values(), key=lambda files: str(files[0].run["started"])):
        parts += [_run(files)]
    rows = [
        [one.path, one.sha256[:16], one.job["ended"], one.run["run"], _what(one.job)]
        for one in sorted(made.values(), key=lambda one: one.path)
    ]
    parts += [
        f"## Files ({len(rows)})\n",
        markdown_rows([["file", "SHA-256 begins", "made", "run", "by"], *rows]),
        "The whole digests and commands are in the run cards, `run_cards/` beside the results.\n",
    ]
    return "\n".join(parts)


def _run(files: Sequence[Made]) -> str:
    run = files[0].run
    code, config = run["code"], run["config"]
    changed = ", ".join(line[3:] for line in code["changed"] or [])
    rows: list[list[Any]] = [
        ["files that still stand", len(files)],
        ["started", run["started"]],
        ["ended", run["ended"] or "with this page or after"],
        ["command", " ".join(Path(word).name if "/" in word else word for word in run["command"])],
        ["code", (code["commit"] or "not in git") + (f", changed: {changed}" if changed else "")],
        ["digest of the code", code["sha256"]],
        ["study's file", f"{config['path']} (SHA-256 {config['sha256']})"],
        ["seeds", ", ".join(f"{name} {value}" for name, value in run["seeds"].items())],
        ["cores", run["cores"]],
        ["hosts", ", ".join(sorted({one.job["host"] for one in files}))],
    ]
    rows += [["device", text] for text in _different(one.job.get("device") for one in files)]
    rows += [["versions", text] for text in _different(one.job.get("versions") for one in files)]
    return f"## Run {run['run']}\n\n" + markdown_rows([["what", "value"], *rows])


def _different(values: Iterable[dict[str, Any] | None]) -> list[str]:
    """The descriptions that there are, each once, as text."""
    once = dict.fromkeys(json.dumps(value, sort_keys=True) for value in values if value)
    return [
        ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in json.loads(text).items())
        for text in once
    ]


def _what(job: dict[str, Any]) -> str:
    return " ".join(job["command"][:2])
