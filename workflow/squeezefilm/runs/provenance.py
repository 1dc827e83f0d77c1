"""What a job of the workflow leaves behind about itself, and whether its results are still wanted.

The workflow gives each job the run that it belongs to, as ``results/STUDY/run_cards/RUN`` in the
environment variable SQUEEZEFILM_RUN. When the job is done it writes a record beside its run's card
(see run_card.py): which files it made, with their digests, on which host, device and versions.
Without the variable, by hand, nothing of this happens.
"""

from __future__ import annotations

import importlib.metadata
import json
import os
import platform
import sys
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from squeezefilm import __version__

RUN_VARIABLE = "SQUEEZEFILM_RUN"
CURRENT = "current"
PACKAGES = (
    "snakemake",
    "numpy",
    "scipy",
    "pandas",
    "matplotlib",
    "pymoo",
    "pyopencl",
    "pocl-binary-distribution",
    "pyarrow",
    "scikit-fem",
)
THREAD_VARIABLES = ("POCL_MAX_PTHREAD_COUNT", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")

_started = time.time()
_written: dict[str, str] = {}
_notes: dict[str, Any] = {}


class Superseded(Exception):
    """The job's run is dead and another one makes the study: the result is not wanted any more."""


def check_wanted() -> None:
    """See that no other run has taken over the study since this job's began.

    A job outlives its run when Snakemake alone is killed. What it computes by then may be of an
    older study or of older code, and must not come over the results of the run that followed.

    Raises:
        Superseded: when another run has begun.
    """
    run = _run()
    if run is None:
        return
    try:
        current = json.loads((run.parent / CURRENT).read_text(encoding="utf-8"))["run"]
    except (OSError, ValueError, KeyError, TypeError):
        return
    if current != run.name:
        raise Superseded(f"run {run.name} ended and {current} has begun: nothing is written")


def note(**facts: Any) -> None:
    """Put facts into the record of this job, such as the device that it computes on."""
    _notes.update(facts)


def note_file(path: Path, *, sha256: str) -> None:
    """Put a file that this job made into its record."""
    _written[str(path)] = sha256


def finish(command: Sequence[str]) -> None:
    """Write the record of this job, if it belongs to a run and made any file."""
    run = _run()
    if run is None or not _written:
        return
    from squeezefilm.runs.atomic import whole_file

    record = {
        "command": list(command),
        "started": timestamp(_started),
        "ended": timestamp(time.time()),
        "host": platform.node(),
        "threads": {name: os.environ[name] for name in THREAD_VARIABLES if name in os.environ},
        "versions": versions(),
        "files": dict(_written),
        **_notes,
    }
    name = f"{platform.node()}-{os.getpid()}-{time.time_ns()}.json"
    with whole_file(jobs_folder(run) / name) as part:
        part.write_text(json.dumps(record, sort_keys=True), encoding="utf-8")
    _written.clear()


def jobs_folder(run: Path) -> Path:
    """Where the records of a run's jobs wait until they are put on its card."""
    return run.with_name(f"{run.name}.jobs")


def versions() -> dict[str, str]:
    """Versions of the system and of the packages that results depend on."""
    found = {
        "squeezefilm": __version__,
        "python": f"{platform.python_version()} ({sys.executable})",
        "system": platform.platform(),
    }
    for name in PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def timestamp(seconds: float) -> str:
    """Seconds since the epoch as text in UTC, which sorts by time."""
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds")


def _run() -> Path | None:
    return Path(os.environ[RUN_VARIABLE]) if os.environ.get(RUN_VARIABLE) else None
