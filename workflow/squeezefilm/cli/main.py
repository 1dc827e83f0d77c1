"""The command line: a module per command, loaded when it is called.

A command ``a-b`` is the module ``a_b`` of a package of commands, found by being there; the first
line of its docstring is what help says of it. Packages above the library add theirs by entry
points.
"""

import argparse
import ast
import gc
import importlib
import importlib.metadata
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from squeezefilm import __version__
from squeezefilm.io import job
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.io.found import modules_in
from squeezefilm.runs import provenance

LIBRARY = ("squeezefilm.cli.use", "squeezefilm.cli.steps", "squeezefilm.cli.upkeep")
ENTRY_POINTS = "squeezefilm.commands"


def installed() -> tuple[str, ...]:
    """The library's packages of commands and, by their entry points, those of packages above it."""
    above = importlib.metadata.entry_points(group=ENTRY_POINTS)
    return (*LIBRARY, *sorted(point.value for point in above))


def commands_of(packages: Sequence[str]) -> dict[str, str]:
    """Every command's module by its name, in the order of the packages."""
    found = (pair for package in packages for pair in modules_in(package).items())
    return {name.replace("_", "-"): module for name, module in found}


def summary_of(module: str) -> str:
    """The first line of a module's docstring; the module is not imported."""
    spec = importlib.util.find_spec(module)
    assert spec is not None
    tree = ast.parse(Path(str(spec.origin)).read_text(encoding="utf-8"))
    return (ast.get_docstring(tree) or "").partition("\n")[0]


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
    commands = commands_of(packages or installed())
    if chosen in commands:
        module = _imported(commands[chosen])
        subparser = subparsers.add_parser(
            chosen,
            description=module.__doc__,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        module.add_arguments(subparser)
        subparser.set_defaults(run=module.run)
    else:
        for name, place in commands.items():
            subparsers.add_parser(name, help=summary_of(place))
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
