"""The two ways a command can end early, each with a message written for the reader."""

from collections.abc import Iterator
from contextlib import contextmanager


class InputError(Exception):
    """What was given is wrong; the message names the file and the place, and what is allowed.

    The command line prints the message without a traceback and exits with status 2.
    """


class RunError(Exception):
    """The work itself could not be completed, for instance because a scene did not converge.

    The command line prints the message without a traceback and exits with status 1.
    """


@contextmanager
def naming(place: object) -> Iterator[None]:
    """Put a place, such as a file's name, before the message of an InputError from within."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{place}: {error}") from None


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
