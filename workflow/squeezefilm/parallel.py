"""The same task on several processes."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

# What forked processes inherit, so that a task need not survive being sent to them.
_task: Callable[[Any], Any] | None = None


def spread(
    task: Callable[[Item], Result], items: Iterable[Item], *, processes: int
) -> list[Result]:
    """``[task(item) for item in items]``, in order, on so many processes.

    Processes are forked, so the task may be any callable; where the system cannot fork safely
    (anything but Linux), one process does it all. Items and results must be picklable.
    """
    global _task
    items = list(items)
    if processes == 1 or len(items) == 1 or sys.platform != "linux":
        return [task(item) for item in items]
    _task = task
    with multiprocessing.get_context("fork").Pool(min(processes, len(items))) as pool:
        return pool.map(_run, items, chunksize=1)


def _run(item: Any) -> Any:
    assert _task is not None
    return _task(item)
