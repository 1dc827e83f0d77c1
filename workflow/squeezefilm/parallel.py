"""Work on several processes, and how far it is."""

import ctypes
import signal
import sys
import threading
from collections.abc import Callable, Iterable
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
    (anything but Linux, or a thread), one process does it all. Items and results must be picklable.
    Raises RunError when one of the processes was killed, for instance for want of memory.
    """
    global _task
    items = list(items)
    main = threading.current_thread() is threading.main_thread()
    if processes == 1 or len(items) == 1 or sys.platform != "linux" or not main:
        return [task(item) for item in items]
    import multiprocessing  # here: most processes share no work
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool

    _task = task
    interrupted = False

    def stop(_signal: int, _frame: object) -> None:
        # An exception out of the middle of forking may be lost; a pool that breaks is not.
        nonlocal interrupted
        interrupted = True
        for process in multiprocessing.active_children():
            process.kill()

    before = signal.signal(signal.SIGINT, stop)
    context = multiprocessing.get_context("fork")
    try:
        with ProcessPoolExecutor(min(processes, len(items)), context, _end_with_parent) as pool:
            # Not `map`, which cancels what a broken pool has not ended yet, at the same time as it.
            futures = [pool.submit(_run, item) for item in items]
            if interrupted:  # before all of them were there
                stop(0, None)
            results = [future.result() for future in futures]
    except BrokenProcessPool:
        if not interrupted:
            raise RunError("one of the processes that shared the work was killed") from None
    finally:
        signal.signal(signal.SIGINT, before)
        if interrupted:
            raise KeyboardInterrupt
    return results


def _end_with_parent() -> None:
    """Let the system kill this process when the one that forked it dies."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _run(item: Any) -> Any:
    assert _task is not None
    return _task(item)


def progress_bar(total: int, *, unit: str, name: str) -> Any:
    """A bar to be closed by ``with`` and moved on by its ``update(count)``; none in a log."""
    from tqdm import tqdm  # slow to import, and only needed here

    return tqdm(total=total, unit=unit, desc=name, disable=None)


def say(text: str) -> None:
    """A line about what is done next."""
    print(text, file=sys.stderr, flush=True)
