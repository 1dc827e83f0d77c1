"""What a job of the workflow leaves behind about itself.

When a job is done it writes a record beside its run's card (see run_card.py): which files it made,
with their digests, on which host, device and versions. By hand, without a run, it does not.
"""

import importlib.metadata
import json
import os
import platform
import sys
import time
from collections.abc import Sequence
from datetime import UTC, datetime

from squeezefilm import __version__
from squeezefilm.io import job
from squeezefilm.io.atomic import write_text

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


def finish(command: Sequence[str]) -> None:
    """Write the record of this job, if it belongs to a run and made any file."""
    run = job.run_of_job()
    if run is None or not job.written:
        return
    record = {
        "command": list(command),
        "started": timestamp(job.started),
        "ended": timestamp(time.time()),
        "host": platform.node(),
        "threads": {name: os.environ[name] for name in THREAD_VARIABLES if name in os.environ},
        "versions": versions(),
        "files": dict(job.written),
        **job.notes,
    }
    name = f"{platform.node()}-{os.getpid()}-{time.time_ns()}.json"
    write_text(json.dumps(record, sort_keys=True), job.jobs_folder(run) / name)
    job.written.clear()


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
