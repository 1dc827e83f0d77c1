"""The frame of a rule's script: where its output goes and how its errors are told."""

import io
import os
import resource
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

import pandas as pd

from squeezefilm.config.film import SMOOTHED_SCAN_ENV_VAR
from squeezefilm.config.loading import load_config
from squeezefilm.config.study import Study
from squeezefilm.errors import InputError, RunError
from squeezefilm.files import write_json, write_text
from squeezefilm.parallel import show_progress
from squeezefilm.table_writer import write_table
from squeezefilm.terminals import SUBSTITUTE_HANDLER_NAME

# Of reynolds/kernel_cache.py, which takes long to import.
NODE_CACHE_ENV_VARIABLE = "SQUEEZEFILM_NODE_CACHE"
Job = Any
"""The object ``snakemake`` that Snakemake puts before a script's first line."""
_terminal_streams: list[TextIO] = []
"""Where Snakemake was started from, beside the log: none before ``run``."""


def run_script(main: Callable[[Job, Study], None], snakemake: Job) -> None:
    """Run a script for a job of Snakemake, all of its output in the log of the job's rule.

    Snakemake fills no log by itself. A script that fails writes its error to the log and the last
    line of the error to the terminal too; Snakemake then removes the outputs of the job.

    Args:
        main: the script; its arguments are the job and the study that the job belongs to.
    """
    # PoCL ignores the processors to which a process is confined; it reads this when it starts.
    os.environ["POCL_MAX_PTHREAD_COUNT"] = str(snakemake.threads)
    # On a cluster home directories are shared by nodes that may differ, over a network that may not
    # lock; profiles/ state this resource. Snakemake's tmpdir is that of the process.
    if snakemake.resources.get("node_cache"):
        os.environ[NODE_CACHE_ENV_VARIABLE] = tempfile.gettempdir()
    terminal = os.fdopen(
        os.dup(2), "w", encoding=sys.stderr.encoding, errors=SUBSTITUTE_HANDLER_NAME
    )
    _terminal_streams.append(terminal)
    with open(snakemake.log[0], "w") as log:  # in the encoding in which Snakemake shows it
        os.dup2(log.fileno(), 1)
        os.dup2(log.fileno(), 2)
    # Other programs write to the same log: a line stands there once it is printed.
    for stream in (sys.stdout, sys.stderr):
        assert isinstance(stream, io.TextIOWrapper)
        stream.reconfigure(
            encoding=log.encoding, errors=SUBSTITUTE_HANDLER_NAME, line_buffering=True
        )
    last = ""
    try:
        config = load_config(snakemake.config["study_file"])
        smoothed = results_folder(snakemake, config) / "profile/smoothed.npz"
        os.environ[SMOOTHED_SCAN_ENV_VAR] = str(smoothed)
        main(snakemake, config)
    except (InputError, RunError) as error:
        last = f"squeezefilm: error: {error}"
        print(last, file=sys.stderr)
    except Exception as error:
        last = "".join(traceback.format_exception_only(error))
        traceback.print_exc()
    finally:
        print_resources_used()
    if last:
        print(last.rstrip(), file=terminal, flush=True)
        sys.exit(1)


def print_result(text: str) -> None:
    """Print a result that people wait for to the log, and to the terminal."""
    print(text)
    for terminal in _terminal_streams:
        print(text, file=terminal, flush=True)


@contextmanager
def show_progress_on_terminal(name: str) -> Iterator[None]:
    """Show on the terminal how far a job is that takes long."""
    with show_progress(name, to=_terminal_streams[-1] if _terminal_streams else sys.stderr):
        yield


def print_resources_used() -> None:
    """Write what this process and its children took, the log's last line."""
    whose = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    used = [resource.getrusage(who) for who in whose]
    seconds = sum(usage.ru_utime + usage.ru_stime for usage in used)
    megabytes = max(usage.ru_maxrss for usage in used) / 1024
    print(f"Used: {seconds:.2f} s of processor time, {megabytes:.0f} MB", flush=True)


def results_folder(snakemake: Job, config: Study) -> Path:
    """The folder of the study's results, in a module below its prefix: each output is in it."""
    name = f"results/{config.study}"
    return Path(f"{str(snakemake.output[0]).partition(f'{name}/')[0]}{name}")


def write_outputs(output: Any, **values: pd.DataFrame | dict[str, Any] | str) -> None:
    """Write values by the names of a rule's outputs: tables, JSON objects, texts."""
    for name, value in values.items():
        if isinstance(value, pd.DataFrame):
            write_table(value, output[name])
        elif isinstance(value, str):
            write_text(value, output[name])
        else:
            write_json(value, output[name])
