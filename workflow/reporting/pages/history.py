"""The runs that made a study's present results, on one page: code, settings, machines, files."""

from collections.abc import Sequence
from pathlib import Path

from squeezefilm.io.errors import InputError
from squeezefilm.io.markdown import markdown_rows
from squeezefilm.runs.run_card import Made, facts_of, made_files


def to_markdown(cards: Path) -> str:
    """The page, from a study's folder of run cards (see run_card.py).

    A run that is still going on is on it too, with the files that it has made so far.
    Raises InputError where no run has made a file.
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
        [
            one.path,
            one.sha256[:16],
            one.job["ended"],
            one.run["run"],
            " ".join(one.job["command"][:2]),
        ]
        for one in sorted(made.values(), key=lambda one: one.path)
    ]
    parts += [
        f"## Files ({len(rows)})\n",
        markdown_rows([["file", "SHA-256 begins", "made", "run", "by"], *rows]),
        "The whole digests and commands are in the run cards, `run_cards/` beside the results.\n",
    ]
    return "\n".join(parts)


def _run(files: Sequence[Made]) -> str:
    run, jobs = files[0].run, [one.job for one in files]
    facts = facts_of(
        run,
        hosts=(job["host"] for job in jobs),
        devices=(job["device"] for job in jobs if "device" in job),
        versions=(job["versions"] for job in jobs if "versions" in job),
    )
    table = markdown_rows([["what", "value"], ["files that still stand", len(files)], *facts])
    return f"## Run {run['run']}\n\n{table}"
