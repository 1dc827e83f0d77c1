"""The card of a run: which code, study, versions, hosts and devices made which files, and when.

A run's card is ``results/STUDY/run_cards/RUN.json``, with a page for people beside it. It is begun
when the run starts and completed when it ends; that of a run which was killed is completed by the
next one. The jobs' own records (provenance.py) are put on it. Times stand here and nowhere else, so
that the results of equal runs are equal.
"""

import contextlib
import hashlib
import json
import shutil
import subprocess
import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from squeezefilm.io.atomic import digest, write_text
from squeezefilm.io.job import jobs_folder, remembered
from squeezefilm.runs.locks import Owner
from squeezefilm.runs.provenance import timestamp, versions
from squeezefilm.studies.config import Config

LIBRARY = Path(__file__).resolve().parents[1]
CODE = LIBRARY.parent
RUNNING, COMPLETED, FAILED, KILLED = "running", "completed", "failed", "killed"


@dataclass(frozen=True)
class Made:
    """One file as a job of a run made it."""

    path: str
    sha256: str
    card: Path
    run: dict[str, Any]
    job: dict[str, Any]


def begin(
    cards: Path,
    owner: Owner,
    *,
    config: Config,
    command: list[str],
    cores: int | None,
) -> None:
    """Begin the card of a run, and complete those of runs that were killed.

    ``cards`` is the study's folder of run cards; the caller holds the study (locks.py).
    """
    from squeezefilm.io.tables import write_json

    for path in sorted(cards.glob("*.json")):
        card = remembered(path)
        late = jobs_folder(path.with_suffix("")).exists()  # jobs that outlived their run
        if card.get("outcome") == RUNNING:
            _complete(path, outcome=KILLED, ended=None)
        elif card and late:
            _complete(path, outcome=card["outcome"], ended=card["ended"])
    card = {
        "run": owner.run,
        "study": config["study"],
        "outcome": RUNNING,
        "started": owner.started,
        "ended": None,
        "command": command,
        "host": owner.host,
        "cores": cores,
        "code": code_state(),
        "config": {
            "path": str(config.path),
            "sha256": digest(config.path),
            "sections": dict(config),
            "not_written": config.origins,
        },
        "seeds": dict(_seeds(config)),
        "versions": versions(),
        "jobs": [],
    }
    write_json(card, cards / f"{owner.run}.json")


def end(cards: Path, owner: Owner, *, outcome: str) -> None:
    """Complete the card of a run: what its jobs made, where, and how it ended."""
    _complete(cards / f"{owner.run}.json", outcome=outcome, ended=timestamp(time.time()))


def code_state() -> dict[str, Any]:
    """The code's commit, whether files differ from it, and the digest of what is there."""
    together = hashlib.sha256()
    for path in sorted(CODE.rglob("*")):
        hidden = any(part.startswith(".") for part in path.relative_to(CODE).parts)
        if path.is_file() and path.suffix != ".pyc" and not hidden:
            together.update(f"{path.relative_to(CODE)} {digest(path)}\n".encode())
    changed = _git("status", "--porcelain", "--untracked-files=normal", "--", ".", ":!results")
    return {
        "sha256": together.hexdigest(),
        "commit": _git("rev-parse", "HEAD"),
        "dirty": None if changed is None else bool(changed),
        "changed": None if changed is None else changed.splitlines(),
    }


def made_files(cards: Path) -> list[Made]:
    """Every file that the runs of a study made, the newest last."""
    found = []
    for path in sorted(cards.glob("*.json")):
        card = remembered(path)
        waiting = [
            remembered(record) for record in jobs_folder(path.with_suffix("")).glob("*.json")
        ]
        for job in [*card.get("jobs", []), *waiting]:
            for name, sha256 in job.get("files", {}).items():
                found.append(Made(name, sha256, path, card, job))
    return sorted(found, key=lambda made: made.job["ended"])


def _complete(path: Path, *, outcome: str, ended: str | None) -> None:
    from squeezefilm.io.tables import write_json

    card = remembered(path)
    folder = jobs_folder(path.with_suffix(""))
    jobs = [*card["jobs"], *(remembered(record) for record in sorted(folder.glob("*.json")))]
    jobs = sorted((job for job in jobs if job), key=lambda job: job["started"])
    hosts = sorted({card["host"], *(job["host"] for job in jobs)})
    card |= {
        "outcome": outcome,
        "ended": ended or max([card["started"], *(job["ended"] for job in jobs)]),
        "jobs": jobs,
        "hosts": hosts,
        "host_count": len(hosts),
        "devices": _different(job["device"] for job in jobs if "device" in job),
        "job_versions": _different(job["versions"] for job in jobs),
    }
    write_json(card, path)
    write_text(to_markdown(card), path.with_suffix(".md"))
    shutil.rmtree(folder, ignore_errors=True)


def to_markdown(card: Mapping[str, Any]) -> str:
    """A card as a page for people."""
    from squeezefilm.io.markdown import markdown_rows

    facts = [
        ["study", card["study"]],
        ["outcome", card["outcome"]],
        *facts_of(
            card,
            hosts=card["hosts"],
            devices=card["devices"],
            versions=card["job_versions"] or [card["versions"]],
        ),
    ]
    files = [
        [name, sha256[:16], job["ended"], job["host"], " ".join(job["command"][:2])]
        for job in card["jobs"]
        for name, sha256 in job["files"].items()
    ]
    return (
        f"# Run {card['run']}\n\n"
        + markdown_rows([["what", "value"], *facts])
        + f"\n## Files made ({len(files)})\n\n"
        + markdown_rows([["file", "SHA-256 begins", "made", "host", "by"], *files])
        + "\nThe whole digests, commands and threads are in the JSON file of the same name.\n"
    )


def facts_of(
    card: Mapping[str, Any],
    *,
    hosts: Iterable[str],
    devices: Iterable[Mapping[str, Any]],
    versions: Iterable[Mapping[str, Any]],
) -> list[list[Any]]:
    """What a page says of a run: rows of a fact and its value, devices and versions each once."""
    code, config = card["code"], card["config"]
    changed = ", ".join(line[3:] for line in code["changed"] or [])
    hosts = sorted(set(hosts))
    return [
        ["started", card["started"]],
        ["ended", card["ended"] or "with this page or after"],
        ["command", " ".join([Path(card["command"][0]).name, *card["command"][1:]])],
        ["code", (code["commit"] or "not in git") + (f", changed: {changed}" if changed else "")],
        ["digest of the code", code["sha256"]],
        ["study's file", f"{config['path']} (SHA-256 {config['sha256']})"],
        ["seeds", ", ".join(f"{name} {value}" for name, value in card["seeds"].items())],
        ["cores", card["cores"]],
        [f"hosts ({len(hosts)})", ", ".join(hosts)],
        *(["device", _listed(each)] for each in _different(devices)),
        *(["versions", _listed(each)] for each in _different(versions)),
    ]


def _listed(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in values.items())


def _seeds(values: Mapping[str, Any], place: str = "") -> Iterator[tuple[str, Any]]:
    """Every key of the configuration that speaks of seeds, with its place."""
    for key, value in values.items():
        if isinstance(value, Mapping) and "seed" not in key:
            yield from _seeds(value, f"{place}{key}.")
        elif "seed" in key:
            yield f"{place}{key}", value


def _different(values: Iterable[Any]) -> list[Any]:
    """The values without repetition, in order."""
    texts = dict.fromkeys(json.dumps(value, sort_keys=True) for value in values)
    return [json.loads(text) for text in texts]


def _git(*arguments: str) -> str | None:
    with contextlib.suppress(OSError, subprocess.TimeoutExpired):
        done = subprocess.run(
            ["git", "-C", str(LIBRARY.parent.parent), *arguments],
            capture_output=True,
            text=True,
            timeout=30,
            check=False,
        )
        return done.stdout.rstrip() if done.returncode == 0 else None
    return None
