"""The job of the workflow that this process is: its run, what it has made, and what is said of it.

The workflow gives each job the run that it belongs to, as ``results/STUDY/run_cards/RUN`` in the
environment variable SQUEEZEFILM_RUN. Without the variable, by hand, nothing of this happens.
"""

import json
import os
import time
from pathlib import Path
from typing import Any

RUN_VARIABLE = "SQUEEZEFILM_RUN"
CURRENT = "current"

started = time.time()
written: dict[str, str] = {}
notes: dict[str, Any] = {}


class Superseded(Exception):
    """The job's run is dead and another one makes the study: the result is not wanted any more."""


def check_wanted() -> None:
    """See that no other run has taken over the study since this job's began.

    A job outlives its run when Snakemake alone is killed. What it computes by then may be of an
    older study or of older code, and must not come over the results of the run that followed.
    Raises Superseded when another run has begun.
    """
    run = run_of_job()
    if run is None:
        return
    current = remembered(run.parent / CURRENT).get("run", run.name)
    if current != run.name:
        raise Superseded(f"run {run.name} ended and {current} has begun: nothing is written")


def note(**facts: Any) -> None:
    """Put facts into the record of this job, such as the device that it computes on."""
    notes.update(facts)


def note_file(path: Path, *, sha256: str) -> None:
    """Put a file that this job made into its record."""
    written[str(path)] = sha256


def remembered(path: Path) -> dict[str, Any]:
    """What is in a file of ours, as JSON; nothing where it is missing or damaged."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def run_of_job() -> Path | None:
    """The card's path, without suffix, of the run that this job belongs to."""
    return Path(os.environ[RUN_VARIABLE]) if os.environ.get(RUN_VARIABLE) else None


def jobs_folder(run: Path) -> Path:
    """Where the records of a run's jobs wait until they are put on its card."""
    return run.with_name(f"{run.name}.jobs")
