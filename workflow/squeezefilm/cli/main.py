"""The command line: a module per command, loaded when it is called.

A package of commands names them, with a line about each, in its ``COMMANDS``; a command ``a-b`` is
the module ``a_b`` there. Packages above the library add theirs by entry points.
"""

from __future__ import annotations

import argparse
import gc
import importlib
import importlib.metadata
import sys
from collections.abc import Sequence
from types import ModuleType

from squeezefilm import __version__
from squeezefilm.io import job
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.runs import provenance

LIBRARY = ("squeezefilm.cli.use", "squeezefilm.cli.steps", "squeezefilm.cli.upkeep")
ENTRY_POINTS = "squeezefilm.commands"


def installed() -> tuple[str, ...]:
    """The library's packages of commands and, by their entry points, those of packages above it."""
    above = importlib.metadata.entry_points(group=ENTRY_POINTS)
    return (*LIBRARY, *sorted(point.value for point in above))


def commands_of(packages: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Every command's module and summary, by its name, in the order of the packages."""
    return {
        name: (f"{package}.{name.replace('-', '_')}", summary)
        for package in packages
        for name, summary in importlib.import_module(package).COMMANDS.items()
    }


def main(arguments: Sequence[str] | None = None, *, packages: Sequence[str] | None = None) -> int:
    """Run one command; return its exit status: 0 done, 1 could not be completed, 2 bad input.

    ``packages`` are those that have the commands, all that are installed if none are named.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    parser = argparse.ArgumentParser(
        prog="squeezefilm",
        description="Squeeze-film forces from the Reynolds equation, and empirical models of them.",
        epilog="`squeezefilm COMMAND --help` explains a command.",
    )
    parser.add_argument("--version", action="version", version=f"squeezefilm {__version__}")
    chosen = words[0] if words else ""
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, (place, summary) in commands_of(packages or installed()).items():
        subparser = subparsers.add_parser(
            name, help=summary, formatter_class=argparse.RawDescriptionHelpFormatter
        )
        if name == chosen:
            module = _imported(place)
            subparser.description = module.__doc__
            module.add_arguments(subparser)
            subparser.set_defaults(run=module.run)
    options = parser.parse_args(words)
    try:
        status = int(options.run(options) or 0)
        provenance.finish(words)
        return status
    except job.Superseded as end:
        print(f"squeezefilm: {end}", file=sys.stderr)
        return 0
    except InputError as error:
        return _complain(error, status=2)
    except RunError as error:
        return _complain(error, status=1)
    except BrokenPipeError:
        return 1
    except KeyboardInterrupt:
        print("squeezefilm: interrupted", file=sys.stderr)
        return 130


def _imported(place: str) -> ModuleType:
    """A command's module; what comes with it is never searched for garbage.

    No module is garbage before the process ends, and looking for it takes a quarter of the time of
    a small command.
    """
    gc.disable()
    try:
        return importlib.import_module(place)
    finally:
        gc.freeze()
        gc.enable()


def _complain(error: Exception, *, status: int) -> int:
    print(f"squeezefilm: error: {error}", file=sys.stderr)
    return status
