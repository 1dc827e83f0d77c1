"""The start of a script that Snakemake runs: where its output goes and how its errors are told."""

import atexit
import os
import resource
import sys
import traceback
from types import TracebackType
from typing import Any

import pandas as pd

from squeezefilm.config.loading import load_config
from squeezefilm.config.study import Study
from squeezefilm.errors import InputError, RunError
from squeezefilm.files import write_text
from squeezefilm.tables import write_json, write_table


def begin() -> Any:
    """Send all output of a script to the log of its rule and return the job, ``snakemake``.

    Snakemake puts ``snakemake`` before a script's first line and fills no log by itself. A script
    that fails writes its error to the log and the last line of it to the terminal too; Snakemake
    then removes the outputs of the job.
    """
    job = sys.modules["__main__"].snakemake
    # PoCL ignores the processors to which a process is confined; it reads this when it starts.
    os.environ["POCL_MAX_PTHREAD_COUNT"] = str(job.threads)
    terminal = os.fdopen(os.dup(2), "w", encoding="utf-8")
    with open(job.log[0], "w", encoding="utf-8") as log:
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)

    def tell(kind: type[BaseException], error: BaseException, place: TracebackType | None) -> None:
        if issubclass(kind, (InputError, RunError)):
            last = f"squeezefilm: error: {error}"
            print(last, file=sys.stderr)
        else:
            *before, last = traceback.format_exception(kind, error, place)
            print(*before, last, sep="", file=sys.stderr)
        print(last.rstrip(), file=terminal, flush=True)

    sys.excepthook = tell
    atexit.register(report_use)
    return job


def report_use() -> None:
    """Write what this process and its children took, the log's last line."""
    whose = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    used = [resource.getrusage(each) for each in whose]
    seconds = sum(each.ru_utime + each.ru_stime for each in used)
    megabytes = max(each.ru_maxrss for each in used) / 1024
    print(f"Used: {seconds:.2f} s of processor time, {megabytes:.0f} MB", flush=True)


def write(output: Any, **values: pd.DataFrame | dict[str, Any] | str) -> None:
    """Write values by the names of a rule's outputs: tables, JSON objects, texts."""
    for name, value in values.items():
        if isinstance(value, pd.DataFrame):
            write_table(value, output[name])
        elif isinstance(value, str):
            write_text(value, output[name])
        else:
            write_json(value, output[name])


def begin_with_study() -> tuple[Any, Study]:
    """Begin a script; the job, and the study that it belongs to."""
    job = begin()
    return job, load_config(job.config["study_file"])
