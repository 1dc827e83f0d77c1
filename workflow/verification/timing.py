"""Run times: processor time of all threads and wall time, medians of repeats."""

import statistics
import time
from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

Result = TypeVar("Result")


class Timed(NamedTuple, Generic[Result]):
    """What a call returned, and the medians of its times in seconds over some repeats."""

    result: Result
    cpu_seconds: float
    wall_seconds: float


def measure(
    call: Callable[[], Result], *, repeats: int, long_seconds: float = 0.2
) -> Timed[Result]:
    """Time a call when it is warm: called once before, then so many times.

    A call that takes more than long_seconds is not repeated: its first run is what it takes, and
    what is done once (imports, compilation) does not show beside it.
    """
    times = []
    for _ in range(repeats + 1):
        wall, cpu = time.perf_counter(), time.process_time()
        result = call()
        times.append((time.process_time() - cpu, time.perf_counter() - wall))
        if times[-1][1] > long_seconds:
            break
    cpu_seconds, wall_seconds = zip(*(times[1:] or times), strict=True)
    return Timed(result, statistics.median(cpu_seconds), statistics.median(wall_seconds))
