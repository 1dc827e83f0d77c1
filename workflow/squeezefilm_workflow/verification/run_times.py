"""Run times: the paper by rule, one force by part, many scenes on host and device."""

import argparse
import inspect
import re
import resource
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from squeezefilm import load
from squeezefilm.cli.options import command, option
from squeezefilm.errors import InputError
from squeezefilm.film.pad import Pad
from squeezefilm.film.scene import Actuator, Film, Gas, Scene
from squeezefilm.parallel import print_step
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.terms import terms_label, terms_of
from squeezefilm.studies.plans import random_plan
from squeezefilm.studies.space import space_of_study
from squeezefilm_workflow.verification.films import PISTON_PROFILE, SHAPE_OF_PAD_NAME
from squeezefilm_workflow.verification.origin import write_with_origin
from squeezefilm_workflow.verification.work_precision import TIMED_FILMS, measure_call_times

PAPER_CONFIG_PATH = "config/paper.yaml"
WORK_PRECISION_PATH = Path("results/paper/numerics/work_precision.csv")
RESOURCES_LINE_PATTERN = re.compile(
    r"^Used: ([\d.]+) s of processor time, (\d+) MB\n\Z", re.MULTILINE
)
"""The last line of a job's log, which `scripts/job.py` writes."""
ONE_FORCE_ARGUMENTS = (
    f"-m squeezefilm simulate --config {PAPER_CONFIG_PATH} --h0 5um --hv 2.2um".split()
)
SNAKEMAKE_DRY_RUN_ARGUMENTS = ["-m", "snakemake", "-n", "--quiet", "all"]
OPENCL_CONTEXT_CODE = "import pyopencl; pyopencl.create_some_context(interactive=False)"
TIMED_PYTHON_CODES = ("pass", "import numpy", OPENCL_CONTEXT_CODE)
SCENES_AND_REPEATS = ((1, 300), (10_000, 5))
"""Scenes of a batch, and how often it is solved; the median counts."""
TERM_SCENE_COUNT, TERM_TOLERANCE = 24, 1e-4
TERM_H0_RANGE_M, TERM_EPSILON_RANGE = (1e-5, 3e-5), (0.05, 0.4)
TERM_PAD_LENGTHS_M = {"square": 35.4e-3, "disc": 40e-3}
GAS_WITHOUT_EFFECTS = Gas(inertia="none", thermal="none")
INERTIA_GAS_KEYS, THERMAL_GAS_KEYS = {"inertia": "included"}, {"thermal": "included"}
"""Pads above a piston, and inertia and thermal effects of the gas, whose scenes are timed."""
TIMING_ROUNDS = 9
"""Of the processes, one after the other; the first warms up, of the others the median counts."""


@command(option("--output", "FOLDER", "for the tables", required=True, type=Path))
def run_times(options: argparse.Namespace) -> None:
    """Measure run times on this machine: six tables.

      make paper && snakemake work_precision
      squeezefilm-verification run-times --output docs/data

    `paper_times.csv`: processor time by rule, of every job that has left a log in logs/paper;
    `force_times.csv`: of one force from the shell by part; `batch_times.csv`: of random scenes of
    the four-factor space, on host and device; `term_times.csv`: of a square and a disc with and
    without inertia and thermal effects; `equal_error.csv`, `equal_error_with_effects.csv`: other
    methods over the solver at an error that is no larger, in the runs of work_precision.csv.
    Nothing else should run meanwhile.
    """
    for name, measured in TABLE_FUNCTIONS.items():
        print_step(f"{name}: measuring")
        table = measured()
        print(table.to_string(index=False))
        path = options.output / f"{name}.csv"
        about = str(inspect.getdoc(measured)).split("\n\n", 1)[0]
        write_with_origin(table, path, command="run-times --output docs/data", about=about)


def paper_run_times(logs: Path = Path("logs/paper")) -> pd.DataFrame:
    """Processor time and memory by rule, from the logs of a finished run, the largest first.

    Raises InputError where no log of the folder is one of a job that ended.
    """
    jobs = pd.DataFrame(
        [
            (path.relative_to(logs).parts[0].removesuffix(".log"), float(used[1]), int(used[2]))
            for path in logs.rglob("*.log")
            if (used := RESOURCES_LINE_PATTERN.search(path.read_text(encoding="utf-8")))
        ],
        columns=["rule", "seconds", "memory"],
    )
    if jobs.empty:
        raise InputError(f"{logs}: has no log of a finished job; run `make paper` first")
    rules = jobs.groupby("rule").agg(
        jobs=("seconds", "size"), seconds=("seconds", "sum"), memory=("memory", "max")
    )
    rules = rules.sort_values("seconds", ascending=False)
    rules.loc["all jobs"] = len(jobs), jobs["seconds"].sum(), jobs["memory"].max()
    names = {"seconds": "processor time (s)", "memory": "largest memory (MB)"}
    return rules.astype({"jobs": int, "memory": int}).round(1).rename(columns=names).reset_index()


def one_force_times() -> pd.DataFrame:
    """Processor time of one force from the shell by what the process does, kernels in the cache."""
    python_alone, with_numpy, with_device = (("-c", code) for code in TIMED_PYTHON_CODES)
    processes = (
        python_alone,
        with_numpy,
        with_device,
        [*ONE_FORCE_ARGUMENTS, "--help"],
        ONE_FORCE_ARGUMENTS,
        SNAKEMAKE_DRY_RUN_ARGUMENTS,
    )
    rounds = [[child_cpu_seconds(*words) for words in processes] for _ in range(TIMING_ROUNDS)]
    python, numpy, device, options, force, nothing = np.median(rounds[1:], axis=0)
    parts = {
        "Python": python,
        "NumPy": numpy - python,
        "PyOpenCL and device": device - numpy,
        "library and options": options - numpy,
        "configuration, kernels from the cache, solution": force - device - options + numpy,
        "all": force,
        "for comparison: Snakemake with nothing to do": nothing,
    }
    milliseconds = [round(1e3 * seconds) for seconds in parts.values()]
    return pd.DataFrame({"part": [*parts], "processor time (ms)": milliseconds})


def batch_times() -> pd.DataFrame:
    """Times per scene of random scenes in one batch and of one scene, warm.

    The host is the main thread; on a processor kernels run on others.
    """
    study, rows = load(PAPER_CONFIG_PATH), []
    points = random_plan(
        points=SCENES_AND_REPEATS[-1][0], seed=1, **space_of_study(study.config).limits
    )
    for (count, repeats), tolerance in product(SCENES_AND_REPEATS, (1e-4, 1e-6)):
        call = partial(solve, study.scenes(points[:count]), tolerance=tolerance)
        _, times = measure_call_times(call, repeats=repeats, long_seconds=np.inf)
        _, processor, host = 1e3 * times / count
        rows.append((count, tolerance, processor, host, processor - host))
    columns = ["scenes", "tolerance", "processor", "host", "kernels"]
    table = pd.DataFrame(rows, columns=columns)
    shown = {name: table[name].map("{:.3g}".format) for name in columns[2:]}
    return table.assign(**shown).rename(columns={name: f"{name} (ms a scene)" for name in shown})


def times_by_term() -> pd.DataFrame:
    """Times per scene and Krylov iterations of two pads above a piston in air, warm."""
    random, rows = np.random.default_rng(1), []
    h0_m = random.uniform(*TERM_H0_RANGE_M, TERM_SCENE_COUNT)
    hv_m = h0_m * random.uniform(*TERM_EPSILON_RANGE, TERM_SCENE_COUNT)
    for (pad, side_m), effects in product(
        TERM_PAD_LENGTHS_M.items(), ({}, INERTIA_GAS_KEYS, INERTIA_GAS_KEYS | THERMAL_GAS_KEYS)
    ):
        actuator = Actuator(20e3, side_m, profile=PISTON_PROFILE)
        film = Film(
            GAS_WITHOUT_EFFECTS, actuator, Pad(side_m, side_m, 0.0, shape=SHAPE_OF_PAD_NAME[pad])
        )
        scenes = [film.scene(*gap_m).with_gas(**effects) for gap_m in zip(h0_m, hv_m, strict=True)]
        call = partial(solve, scenes, tolerance=TERM_TOLERANCE)
        solutions, (_, processor, _) = measure_call_times(call, repeats=5, long_seconds=np.inf)
        milliseconds = f"{1e3 * processor / TERM_SCENE_COUNT:.2g}"
        solved = int(np.sum(solutions.status == "ok"))
        iterations = f"{np.mean(solutions.krylov_iterations):.0f}"
        terms = terms_label(terms_of(scenes[0]))
        rows.append((f"{pad}, {1e3 * side_m:g} mm", terms, solved, milliseconds, iterations))
    columns = ["pad", "terms", "solved", "processor (ms a scene)", "Krylov iterations"]
    return pd.DataFrame(rows, columns=columns)


def equal_error(films: tuple[Scene, ...] = TIMED_FILMS[1:2]) -> pd.DataFrame:
    """First and last run of each other method on films, and the solver's at equal error.

    Of those runs in WORK_PRECISION_PATH that a run of the solver is no worse than.
    Raises InputError where there is no such file.
    """
    if not WORK_PRECISION_PATH.exists():
        raise InputError(f"{WORK_PRECISION_PATH}: is missing; run `snakemake work_precision` first")
    runs = pd.read_csv(WORK_PRECISION_PATH).dropna(subset="speedup")
    runs = runs[runs["case"].isin([film.point_id for film in films])]
    runs["relative_error"] = runs["relative_error"].clip(lower=runs["reference_uncertainty"])
    ends = runs.groupby(["case", "method"], sort=False).nth([0, -1])
    columns = {
        "its error": "relative_error",
        "its seconds": "cpu_s",
        "its seconds over the solver's, one film": "speedup",
        "over the solver's per film of 100": "speedup_in_batch",
    }
    shown = {
        name: [f"{float(f'{number:.2g}'):g}" for number in ends[column]]
        for name, column in columns.items()
    }
    return pd.DataFrame({"film": ends["case"], "other method": ends["method"], **shown})


def equal_error_with_effects() -> pd.DataFrame:
    """First and last run of dense collocation with inertia and thermal effects, at equal error."""
    return equal_error(TIMED_FILMS[4:])


TABLE_FUNCTIONS: dict[str, Callable[[], pd.DataFrame]] = {
    "paper_times": paper_run_times,
    "force_times": one_force_times,
    "batch_times": batch_times,
    "term_times": times_by_term,
    "equal_error": equal_error,
    "equal_error_with_effects": equal_error_with_effects,
}
"""What measures each table, by the table's name."""


def child_cpu_seconds(*words: str) -> float:
    """Return the processor seconds of a Python process.

    Raises subprocess.CalledProcessError where it fails.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *words], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
