"""The same task on several processes: a parallel map."""

import ctypes
import multiprocessing
import signal
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from squeezefilm.errors import RunError

Item = TypeVar("Item")
Result = TypeVar("Result")

# What forked processes inherit, so that a task need not survive being sent to them.
_task: Callable[[Any], Any] | None = None
_PR_SET_PDEATHSIG = 1


def parallel_map(
    task: Callable[[Item], Result], items: Iterable[Item], *, processes: int
) -> list[Result]:
    """``[task(item) for item in items]``, in order, on so many processes.

    Processes are forked, so the task may be any callable; where the system cannot fork safely
    (anything but Linux), one process does it all. Items and results must be picklable.
    Raises RunError when one of the processes was killed, for instance for want of memory.
    """
    global _task
    items = list(items)
    if processes == 1 or len(items) == 1 or sys.platform != "linux":
        return [task(item) for item in items]
    _task = task
    with ProcessPoolExecutor(
        min(processes, len(items)), multiprocessing.get_context("fork"), _end_with_parent
    ) as pool:
        try:
            # Processes are forked here with Ctrl-C held back, and leave it to this one for good.
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
            try:
                results = pool.map(_run, items)
            finally:
                signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
            return list(results)
        except BrokenProcessPool:
            raise RunError("one of the processes that shared the work was killed") from None
        except KeyboardInterrupt:  # the pool would wait for the tasks that have begun
            for process in multiprocessing.active_children():
                process.kill()
            raise


def _end_with_parent() -> None:
    """Have the system kill this process when the one that forked it dies, however that comes."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _run(item: Any) -> Any:
    assert _task is not None
    return _task(item)
