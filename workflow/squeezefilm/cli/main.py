"""The command line: a module per command, loaded when it is called.

A command ``a-b`` is the module ``a_b`` of a package of commands, found by being there; the first
line of its docstring is what help says of it. Packages above the library add theirs by entry
points. Help shows the packages as groups, each under the first line of its docstring.
"""

import argparse
import ast
import difflib
import gc
import importlib
import importlib.metadata
import importlib.util
import re
import sys
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType

from squeezefilm import __version__
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.io.found import modules_in

LIBRARY = ("squeezefilm.cli.use", "squeezefilm.cli.study")
ENTRY_POINTS = "squeezefilm.commands"
NEGATIVE = re.compile(r"-\.?\d")
OPTION = re.compile(r"--[a-z][a-z0-9-]*")
NAME_WIDTH, WIDTH = 18, 100


def installed() -> tuple[str, ...]:
    """The library's packages of commands and, by their entry points, those of packages above it.

    The packages above lie beside the library in a checkout; without one they are not there.
    """
    above = sorted(point.value for point in importlib.metadata.entry_points(group=ENTRY_POINTS))
    there = (
        name
        for name in above
        if importlib.util.find_spec(name.partition(".")[0]) and importlib.util.find_spec(name)
    )
    return (*LIBRARY, *there)


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
    """Run one command and return its exit status.

    The status is 0 for done, 1 for what could not be completed, 2 for invalid input, 130 after
    Ctrl-C, at which the loading of a command ends in one line as well.

    Args:
        packages: those that have the commands, all that are installed if none are named.
    """
    try:
        return _run(arguments, packages=packages)
    except KeyboardInterrupt:
        print("squeezefilm: interrupted", file=sys.stderr)
        return 130


def _run(arguments: Sequence[str] | None, *, packages: Sequence[str] | None) -> int:
    words = with_negative_values(sys.argv[1:] if arguments is None else arguments)
    packages = packages or installed()
    commands = commands_of(packages)
    chosen = words[0] if words else ""
    parser = argparse.ArgumentParser(
        prog="squeezefilm",
        usage=None if chosen in commands else "squeezefilm COMMAND …",
        description="Squeeze-film forces from the Reynolds equation, and empirical models of them.",
        epilog=None if chosen in commands else overview(packages),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"squeezefilm {__version__}")
    asked = parser
    if chosen in commands:
        subparsers = parser.add_subparsers(dest="command", metavar="COMMAND")
        module = _imported(commands[chosen])
        asked = subparsers.add_parser(
            chosen,
            description=module.__doc__,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        module.add_arguments(asked)
        asked.set_defaults(run=module.run)
    elif not chosen.startswith("-"):
        parser.error(_unknown(chosen, commands))
    options, unknown = parser.parse_known_args(words)
    if unknown:
        parser.error(_unknown_option(unknown[0], asked))
    try:
        return int(options.run(options) or 0)
    except InputError as error:
        return _complain(error, status=2)
    except RunError as error:
        return _complain(error, status=1)
    except BrokenPipeError:
        return 1


def with_negative_values(words: Sequence[str]) -> list[str]:
    """Words of a command line in which no value looks like an option: ``--x -2mm`` as one word."""
    found: list[str] = []
    for word in words:
        if found and NEGATIVE.match(word) and OPTION.fullmatch(found[-1]):
            found[-1] += f"={word}"
        else:
            found.append(word)
    return found


def overview(packages: Sequence[str]) -> str:
    """Every command with a line about it, in groups."""
    lines = []
    for package in packages:
        lines.append(summary_of(package).removesuffix("."))
        for name, place in commands_of([package]).items():
            about = textwrap.wrap(summary_of(place), WIDTH - NAME_WIDTH - 2)
            first, *rest = about or [""]
            lines.append(f"  {name:{NAME_WIDTH}}{first}")
            lines += [f"{'':{NAME_WIDTH + 2}}{line}" for line in rest]
        lines.append("")
    return "\n".join([*lines, "`squeezefilm COMMAND --help` explains a command."])


def _unknown(chosen: str, commands: Mapping[str, str]) -> str:
    if not chosen:
        return "which command? `squeezefilm --help` names them"
    near = difflib.get_close_matches(chosen, commands, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"there is no command {chosen!r}; {hint}`squeezefilm --help` names all"


def _unknown_option(word: str, parser: argparse.ArgumentParser) -> str:
    known = [name for action in parser._actions for name in action.option_strings]
    near = difflib.get_close_matches(word.partition("=")[0], known, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"{parser.prog} takes no {word!r}; {hint}`{parser.prog} --help` explains what it takes"


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
