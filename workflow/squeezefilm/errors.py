"""The two ways a command can end early, each with a message written for the reader."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

Result = TypeVar("Result")


class InputError(Exception):
    """Invalid input; the message names the file, the place and what is allowed.

    The command line prints the message without a traceback and exits with status 2.
    """


class RunError(Exception):
    """The work itself could not be completed, for instance because a scene did not converge.

    The command line prints the message without a traceback and exits with status 1.
    """


def check_problems(source: object, problems: Mapping[str, object]) -> None:
    """Raise an InputError with the first problem whose condition holds."""
    for problem, wrong in problems.items():
        if wrong:
            raise InputError(f"{source}: {problem}")


@contextmanager
def prefix_errors(source: object) -> Iterator[None]:
    """Put a place, such as a file's name, before the message of an InputError from within.

    Without a place, None, the message stays; so does one that begins with the place.
    """
    try:
        yield
    except InputError as error:
        named = not source or str(error).startswith(f"{source}: ")
        raise InputError(str(error) if named else f"{source}: {error}") from None


@contextmanager
def needing(extra: str, *, what: str) -> Iterator[None]:
    """Imports within are of packages that only an extra of the library brings.

    Raises InputError saying what needs them and how they are installed.
    """
    try:
        yield
    except ImportError as error:
        raise InputError(
            f"{what} needs {error.name or 'a package'}: pip install 'squeezefilm[{extra}]'"
        ) from None


def retried_singly(
    work: Callable[[Any], Sequence[Result]], items: Any, *, failed: Callable[[Exception], Result]
) -> Sequence[Result]:
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
        for result in retried_singly(work, items_half, failed=failed)
    ]


def unexpected(error: Exception) -> str:
    """The status of what ended in an error which no method foresees."""
    return " ".join(f"unexpected error: {type(error).__name__}: {error}".split())
