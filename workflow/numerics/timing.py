"""Run times: processor time of all threads, wall time, medians of repeats, cold starts."""

import os
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from squeezefilm.io.errors import RunError

Result = TypeVar("Result")


@dataclass(frozen=True)
class Timed(Generic[Result]):
    """What a call returned, and the medians of its times in seconds over some repeats."""

    result: Result
    cpu_seconds: float
    wall_seconds: float
    repeats: int


def processor_seconds() -> float:
    """Processor time of this process, its threads and the processes that it has waited for."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def measure(
    call: Callable[[], Result], *, repeats: int, long_seconds: float = 0.2
) -> Timed[Result]:
    """Time a call when it is warm: called once before, then so many times.

    A call that takes more than long_seconds is not repeated: its first run is what it takes, and
    what is done once (imports, compilation) does not show beside it.
    """
    cpu: list[float] = []
    wall: list[float] = []
    for index in range(repeats + 1):
        wall_start, cpu_start = time.perf_counter(), processor_seconds()
        result = call()
        cpu_spent, wall_spent = processor_seconds() - cpu_start, time.perf_counter() - wall_start
        if index > 0 or wall_spent > long_seconds:
            cpu.append(cpu_spent)
            wall.append(wall_spent)
        if wall_spent > long_seconds:
            break
    return Timed(result, statistics.median(cpu), statistics.median(wall), len(cpu))


def cold_start(code: str, *, environment: dict[str, str] | None = None) -> tuple[float, float]:
    """CPU and wall seconds of a new Python process that runs some code.

    environment: variables on top of those of this process.
    Raises RunError when the code fails.
    """
    before, start = processor_seconds(), time.perf_counter()
    run_python(code, what="a cold start", environment=environment)
    return processor_seconds() - before, time.perf_counter() - start


def run_python(code: str, *, what: str, environment: dict[str, str] | None = None) -> str:
    """What a new Python process that runs some code says; RunError when it fails."""
    run = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **(environment or {})},
        capture_output=True,
        text=True,
        check=False,
    )
    if run.returncode:
        raise RunError(f"{what} failed: {run.stderr.strip().splitlines()[-1]}")
    return run.stdout
