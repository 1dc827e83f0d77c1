"""Where run time goes: the paper by rule, one force by part, many scenes on host and device."""

import argparse
import os
import re
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from statistics import median

import numpy as np
import pandas as pd

from squeezefilm import load
from squeezefilm.cli.options import command, option
from squeezefilm.errors import InputError
from squeezefilm.files import write_text
from squeezefilm.parallel import say
from squeezefilm.provenance import provenance
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.studies.plans import random_plan

PAPER = "config/paper.yaml"
USED = re.compile(r"^Used: ([\d.]+) s of processor time, (\d+) MB\n\Z", re.MULTILINE)
"""The last line of a job's log, which `scripts/job.py` writes."""
ONE_FORCE = ("-m", "squeezefilm", "simulate", "--config", PAPER, "--h0", "5um", "--hv", "2.2um")
NOTHING = ("-m", "snakemake", "-n", "--quiet", "all")
DEVICE = "import pyopencl; pyopencl.create_some_context(interactive=False)"
MANY = 10_000
"""Scenes of a batch."""
SPACE = {
    "h0_m": (5e-6, 10e-6),
    "hv_m": (0.2e-6, 2.2e-6),
    "phi_r_m": (0.0, 2.8e-3),
    "phi_deg": (0.0, 45.0),
}
"""The four-factor space, without the places at which gaps close."""


@command(
    option("--output", "FOLDER", "for the tables", required=True, type=Path),
    option("--logs", "FOLDER", "of a run of the paper; default logs/paper", default="logs/paper"),
    option("--repeats", help="of a time; the median counts; default 5", type=int, default=5),
)
def run_times(options: argparse.Namespace) -> None:
    """Where run time goes on this machine: three tables.

      make paper && python -m verification run-times --output docs/data

    `paper_times.csv`: processor time of `make paper` by rule, from the ends of the jobs' logs;
    `force_times.csv`: of one force from the shell by part; `batch_times.csv`: of random scenes of
    the four-factor space, on host and device. Nothing else should run meanwhile.
    """
    device = choose_device()
    now = datetime.now(UTC)
    origin = {
        "command": "python -m verification run-times --output docs/data",
        "commit": str(provenance({}, device={})["commit"])[:8],
        "machine": f"{device.name}, {os.cpu_count()} cores",
        "date": f"{now.day} {now:%B %Y}",
    }
    tables = {
        "paper": lambda: paper_times(
            Path(options.logs), nothing_s=child_seconds(NOTHING, repeats=options.repeats)
        ),
        "force": lambda: force_times(repeats=options.repeats),
        "batch": lambda: batch_times(repeats=options.repeats),
    }
    for name, measured in tables.items():
        say(f"{name}: measuring")
        head = "".join(f"# {key}: {value}\n" for key, value in origin.items())
        rows = measured().to_csv(index=False)
        write_text(head + rows, options.output / f"{name}_times.csv")


def paper_times(logs: Path, *, nothing_s: float) -> pd.DataFrame:
    """Processor time and memory by rule, from the logs of a finished run, the largest first.

    Args:
        nothing_s: seconds that Snakemake takes to see that nothing is to be done.

    Raises InputError where no log of the folder is one of a job that ended.
    """
    jobs = pd.DataFrame(
        [
            (path.relative_to(logs).parts[0].removesuffix(".log"), float(used[1]), int(used[2]))
            for path in logs.rglob("*.log")
            if (used := USED.search(path.read_text(encoding="utf-8")))
        ],
        columns=["rule", "seconds", "memory"],
    )
    if jobs.empty:
        raise InputError(f"{logs}: has no log of a finished job; run `make paper` first")
    grouped = jobs.groupby("rule")
    rules = grouped.agg({"seconds": "sum", "memory": "max"}).assign(jobs=grouped.size())
    rules = rules.sort_values("seconds", ascending=False)
    rules.loc["all jobs"] = jobs["seconds"].sum(), jobs["memory"].max(), len(jobs)
    rules.loc["Snakemake with nothing to do"] = nothing_s, float("nan"), float("nan")
    return pd.DataFrame(
        {
            "rule": rules.index,
            "jobs": rules["jobs"].astype("Int64"),
            "processor time (s)": rules["seconds"].round(1),
            "largest memory (MB)": rules["memory"].astype("Int64"),
        }
    )


def force_times(*, repeats: int) -> pd.DataFrame:
    """Processor time of one force from the shell by what the process does, kernels in the cache."""
    python, numpy, device, options, force = (
        child_seconds(words, repeats=repeats)
        for words in (
            ("-c", "pass"),
            ("-c", "import numpy"),
            ("-c", DEVICE),
            (*ONE_FORCE, "--help"),
            ONE_FORCE,
        )
    )
    parts = {
        "Python": python,
        "NumPy": numpy - python,
        "PyOpenCL and device": device - numpy,
        "library and options": options - numpy,
        "configuration, kernels from the cache, solution": force - device - options + numpy,
        "all": force,
    }
    milliseconds = [round(1e3 * seconds) for seconds in parts.values()]
    return pd.DataFrame({"part": [*parts], "processor time (ms)": milliseconds})


def batch_times(*, repeats: int) -> pd.DataFrame:
    """Times per scene of random scenes in one batch and of one scene, warm.

    The host is the main thread; on a processor kernels run on others.
    """
    study, rows = load(PAPER), []
    points = random_plan(points=MANY, seed=1, **SPACE)
    for count, tolerance in product((1, MANY), (1e-4, 1e-6)):
        scenes = study.scenes(points[:count])
        solve(scenes, tolerance=tolerance)
        clocks = time.perf_counter, time.process_time, time.thread_time
        taken = []
        for _ in range(repeats):
            before = [clock() for clock in clocks]
            solve(scenes, tolerance=tolerance)
            taken.append([clock() - start for clock, start in zip(clocks, before, strict=True)])
        wall, processor, host = 1e3 * np.median(taken, axis=0) / count
        rows.append((count, tolerance, wall, processor, host, processor - host))
    columns = ["scenes", "tolerance", "wall", "processor", "host", "kernels"]
    table = pd.DataFrame(rows, columns=columns)
    times = {name: table[name].map("{:.3g}".format) for name in columns[2:]}
    return table.assign(**times).rename(columns={name: f"{name} (ms a scene)" for name in times})


def child_seconds(words: Sequence[str], *, repeats: int) -> float:
    """Return the median of the processor seconds of a Python process, which has run once before.

    Raises subprocess.CalledProcessError where it fails.
    """
    taken = []
    for _ in range(repeats + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *words], check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        taken.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return median(taken[1:])
