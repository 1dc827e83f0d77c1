"""The two ways a command can end early, each with a message written for the reader."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

ResultT = TypeVar("ResultT")


class InputError(Exception):
    """Invalid input; the message names the file, the place and what is allowed.

    The command line prints the message without a traceback and exits with status 2.
    """


class RunError(Exception):
    """The work itself could not be completed, for instance because a scene did not converge.

    The command line prints the message without a traceback and exits with status 1.
    """


def raise_first_problem(source: object, problems: Mapping[str, object]) -> None:
    """Raise an InputError with the first problem whose condition holds."""
    for problem, wrong in problems.items():
        if wrong:
            raise InputError(f"{source}: {problem}")


MAX_ROWS_IN_MESSAGE = 20
"""Rows of a table that one message names, at most."""


def raise_row_problems(problems: Sequence[str], *, count: int | None = None) -> None:
    """Raise an InputError with a line for each problem, if there is one.

    Args:
        count: number of problems, where those given are only the first of them.
    """
    more = (len(problems) if count is None else count) - MAX_ROWS_IN_MESSAGE
    if problems:
        lines = [*problems[:MAX_ROWS_IN_MESSAGE], *([f"and {more} more"] if more > 0 else [])]
        raise InputError("\n".join(lines))


def point_text(point_id: object) -> str:
    """Return a point's name for a message; a row without a name is called by its line."""
    return f"{point_id}" if f"{point_id}".startswith("line ") else f"point {point_id}"


@contextmanager
def prefix_errors(source: object) -> Iterator[None]:
    """Put a place, such as a file's name, before each line of an InputError from within.

    Without a place, None, the message stays; so does a line that begins with the place.
    """
    try:
        yield
    except InputError as error:
        start = f"{source}: " if source else ""
        lines = str(error).splitlines()
        named = [line if line.startswith(start) else start + line for line in lines]
        raise InputError("\n".join(named)) from None


@contextmanager
def append_remedy(remedy: str) -> Iterator[None]:
    """Put what mends it behind an InputError from within."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{error}; {remedy}") from None


@contextmanager
def imports_from_extra(extra: str, *, what: str) -> Iterator[None]:
    """Imports within are of packages that only an extra of the library brings.

    Raises InputError saying what needs them and how they are installed.
    """
    try:
        yield
    except ImportError as error:
        raise InputError(
            f"{what} needs {error.name or 'a package'}: pip install 'squeezefilm[{extra}]'"
        ) from None


def apply_with_bisection(
    work: Callable[[Any], Sequence[ResultT]], items: Any, *, failed: Callable[[Exception], ResultT]
) -> Sequence[ResultT]:
    """Apply ``work`` to all items; after an unexpected error to each half, and so on.

    Raises:
        InputError: that of ``work``, such as a device that is not there: it concerns all of them.
    """
    if not len(items):
        return []
    try:
        return work(items)
    except InputError:
        raise
    except Exception as error:
        if len(items) == 1:
            return [failed(error)]
    half = len(items) // 2
    halves = (items[:half], items[half:])
    return [
        result
        for items_half in halves
        for result in apply_with_bisection(work, items_half, failed=failed)
    ]


def unexpected_error_status(error: Exception) -> str:
    """The status of what ended in an error which no method foresees."""
    return " ".join(f"unexpected error: {type(error).__name__}: {error}".split())
