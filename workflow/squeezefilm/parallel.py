"""Parallel work in processes, and its progress."""

import ctypes
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TextIO, TypeVar

from squeezefilm.errors import RunError

ItemT = TypeVar("ItemT")
ResultT = TypeVar("ResultT")

# What forked processes inherit, so that a task need not survive being sent to them.
_inherited_task: Callable[[Any], Any] | None = None
_PR_SET_PDEATHSIG = 1
# Time without a line of progress, in s.
PROGRESS_INTERVAL_S = 10.0
_progress_stack: list["Progress"] = []


def parallel_map(
    task: Callable[[ItemT], ResultT], items: Iterable[ItemT], *, processes: int
) -> list[ResultT]:
    """``[task(item) for item in items]``, in order, on so many processes.

    Processes are forked, so the task may be any callable; where the system cannot fork safely
    (anything but Linux, or a thread), one process does it all. Items and results must be picklable.
    Raises RunError when one of the processes was killed, for instance for want of memory.
    """
    global _inherited_task
    items = list(items)
    main = threading.current_thread() is threading.main_thread()
    if processes == 1 or len(items) == 1 or sys.platform != "linux" or not main:
        return [task(item) for item in items]
    import multiprocessing  # here: most processes share no work
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool

    _inherited_task = task
    interrupted = False

    def stop_children(_signal: int, _frame: object) -> None:
        # An exception out of the middle of forking may be lost; a pool that breaks is not.
        nonlocal interrupted
        interrupted = True
        for process in multiprocessing.active_children():
            process.kill()

    before = signal.signal(signal.SIGINT, stop_children)
    context = multiprocessing.get_context("fork")
    try:
        with ProcessPoolExecutor(min(processes, len(items)), context, _die_with_parent) as pool:
            # Not `map`, which cancels what a broken pool has not ended yet, at the same time as it.
            futures = [pool.submit(_run_inherited_task, item) for item in items]
            if interrupted:  # before all of them were there
                stop_children(0, None)
            results = [future.result() for future in futures]
    except BrokenProcessPool:
        if not interrupted:
            raise RunError("one of the processes that shared the work was killed") from None
    finally:
        signal.signal(signal.SIGINT, before)
        if interrupted:
            raise KeyboardInterrupt
    return results


def _die_with_parent() -> None:
    """Let the system kill this process when the one that forked it dies."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _run_inherited_task(item: Any) -> Any:
    assert _inherited_task is not None
    return _inherited_task(item)


@dataclass
class Progress:
    """Work that is under way: the finished part of a total, and what is done now."""

    name: str
    unit: str
    total: int
    done: int = 0
    current_step: str = ""

    def update(self, count: int) -> None:
        self.done += count

    def __str__(self) -> str:
        text = f"{self.name}: {self.done} of {self.total} {self.unit}s"
        return f"{text} ({self.current_step})" if self.current_step else text


@contextmanager
def track_progress(total: int, *, unit: str, name: str) -> Iterator[Progress]:
    """Work that ``show_progress`` shows, within that which is under way."""
    progress = Progress(name, unit, total)
    _progress_stack.append(progress)
    try:
        yield progress
    finally:
        _progress_stack.remove(progress)


@contextmanager
def show_progress(command: str, *, to: TextIO | None = None) -> Iterator[None]:
    """Show on stderr how far a command is, each time that PROGRESS_INTERVAL_S have gone by.

    A terminal has one line that changes; elsewhere each time has its own.

    Args:
        to: a stream in place of stderr.
    """
    ended, start, stream = threading.Event(), time.monotonic(), to or sys.stderr
    before, after = ("\r\033[K", "") if stream.isatty() else ("", "\n")

    def print_progress() -> None:
        while not ended.wait(PROGRESS_INTERVAL_S):
            parts = [f"{command}: {time.monotonic() - start:.0f} s", *map(str, _progress_stack)]
            print(before + "; ".join(parts), end=after, file=stream, flush=True)
        if before and time.monotonic() - start > PROGRESS_INTERVAL_S:
            print(before, end="", file=stream, flush=True)

    thread = threading.Thread(target=print_progress, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def print_step(text: str) -> None:
    """A line about what is done next."""
    print(text, file=sys.stderr, flush=True)
