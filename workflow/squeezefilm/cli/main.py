"""The command line: commands in modules, which are loaded when one of them is called."""

import argparse
import atexit
import gc
import importlib
import importlib.util
import os
import re
import signal
import sys
import textwrap
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import NoReturn

from squeezefilm import __version__
from squeezefilm.errors import InputError, RunError
from squeezefilm.terminals import enable_ascii_substitutes

CommandGroups = Mapping[str, Mapping[str, str]]

COMMAND_GROUPS: CommandGroups = {
    "Forces, fields and fitted models": {
        "squeezefilm.cli.film": "simulate error-budget pressure",
        "squeezefilm.cli.dynamics": "levitate response",
        "squeezefilm.cli.model": "predict amplitude-for export",
        "squeezefilm.cli.setup": "config doctor",
    },
    "A study of your own": {
        "squeezefilm.cli.setup": "new",
        "squeezefilm.cli.study": "profile fit validate optimal",
    },
    "A finished study": {
        "squeezefilm_workflow.reporting.commands": "plot plot-pressure recommend check reference",
    },
}
"""Commands by the titles of their groups and their modules, where ``a-b`` is ``a_b``."""
INTERRUPTED_MESSAGE = "squeezefilm: interrupted\n"
# Threads of NumPy's libraries wait for each other where the solver's keep all cores busy: the
# modes of one ellipse (terms/outline.py) took 14 s on two threads and 0.2 s on one.
THREAD_COUNT_ENV_VARIABLES = "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"
# Else pydantic reads the metadata of every installed package for plugins of its own.
PYDANTIC_PLUGINS_ENV_SETTING = "PYDANTIC_DISABLE_PLUGINS", "__all__"
# Containers made since the last search for garbage that start the next; by Python's 700 the import
# of PyOpenCL alone starts thirty.
GARBAGE_COLLECTION_THRESHOLD = 50_000
NEGATIVE_NUMBER_PATTERN, OPTION_PATTERN = re.compile(r"-\.?\d"), re.compile(r"--[\w-]+")
SYNONYMS_OF_OPTION = {
    "h0": "gap mean-gap height thickness h ho",
    "hv": "amplitude amp a",
    "x": "position pos x-position",
    "y": "position pos y-position",
    "phi-r": "r radius distance",
    "phi": "angle direction",
    "load": "force weight f",
    "mass": "weight m",
    "force": "load mass target f",
    "output": "out o file save",
    "outputs": "quantities quantity stiffness damping",
    "config": "study configfile yaml c",
    "tolerance": "accuracy error rtol",
}
"""What people call options, by the names that options have here, without dashes."""
HINTS_TO_OTHER_COMMANDS = {
    "h0": "`squeezefilm levitate` finds the gap; for a given gap use `squeezefilm simulate`; ",
    "outputs": "`squeezefilm simulate --outputs` computes further quantities at a given gap; ",
}
"""By the names of options, for commands that do not have them."""
COMMAND_NAME_WIDTH, OVERVIEW_WIDTH = 18, 100
SUMMARY_PATTERN = re.compile(r'^def (\w+)\(options: .*:\n +"""(.*)', re.MULTILINE)


def modules_by_command(groups: CommandGroups = COMMAND_GROUPS) -> dict[str, str]:
    """The place of every command by its name; a package that is not installed has none.

    What shows a finished study lies beside the library in a checkout, and not in its wheel.
    """
    return {
        name: module
        for group in groups.values()
        for module, names in group.items()
        if importlib.util.find_spec(module.partition(".")[0])
        for name in names.split()
    }


@cache
def command_summaries(place: str) -> dict[str, str]:
    """The first line of each command's docstring, by its function in a module; not imported."""
    spec = importlib.util.find_spec(place)
    assert spec is not None
    return dict(SUMMARY_PATTERN.findall(Path(str(spec.origin)).read_text(encoding="utf-8")))


def main(
    arguments: Sequence[str] | None = None,
    *,
    groups: CommandGroups = COMMAND_GROUPS,
    program: str = "squeezefilm",
) -> int:
    """Run one command of a program and return its exit status.

    The status is 0 for done, 1 for what could not be completed, 2 for invalid input, 130 after
    Ctrl-C, at which the loading of a command ends in one line as well.
    """
    enable_ascii_substitutes(sys.stdout, sys.stderr)
    try:
        words = sys.argv[1:] if arguments is None else arguments
        return _run_command(words, groups=groups, program=program)
    except KeyboardInterrupt:
        sys.stderr.write(INTERRUPTED_MESSAGE)
        return 130
    except (InputError, RunError) as error:
        print(f"squeezefilm: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, InputError) else 1
    except BrokenPipeError:
        return 1


def _run_command(arguments: Sequence[str], *, groups: CommandGroups, program: str) -> int:
    commands, chosen = modules_by_command(groups), arguments[0] if arguments else ""
    if chosen not in commands:
        overview = overview_text(groups)
        _print_help_and_exit(arguments, commands, overview=overview, program=program)
    for name in THREAD_COUNT_ENV_VARIABLES:
        os.environ.setdefault(name, "1")
    os.environ.setdefault(*PYDANTIC_PLUGINS_ENV_SETTING)
    # No module is garbage before the process ends, and then all is; searches for garbage would take
    # a quarter of the time of a small command.
    atexit.register(gc.freeze)
    gc.disable()
    with _exit_on_interrupt():
        command = getattr(importlib.import_module(commands[chosen]), chosen.replace("-", "_"))
    gc.freeze()
    gc.set_threshold(GARBAGE_COLLECTION_THRESHOLD)
    gc.enable()
    # With difflib two thirds of what `squeezefilm --help` would load.
    import inspect

    from squeezefilm.parallel import show_progress

    parser = argparse.ArgumentParser(
        prog=f"{program} {chosen}",
        description=inspect.cleandoc(command.run.__doc__),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    actions = [action for add in command.options for action in add(parser)]
    words = join_negative_values(arguments[1:])
    known = ["--help", *(name for action in actions for name in action.option_strings)]
    # By another name first: argparse would find `--out` ambiguous, or miss a required option.
    unknown = [word for word in words if word.startswith("-") and _option_hint(word, known)]
    if not unknown:
        options, unknown = parser.parse_known_args(words)
    if unknown:
        hint = _option_hint(unknown[0], known) or _nearest_name_hint(
            unknown[0].partition("=")[0], known
        )
        what = f"takes no {unknown[0]!r}; {hint}`{parser.prog} --help` explains what it takes"
        parser.error(what)
    with show_progress(parser.prog):
        return int(command.run(options) or 0)


def join_negative_values(arguments: Sequence[str]) -> list[str]:
    """Words of which ``--x -2mm`` is ``--x=-2mm``: argparse takes such values for options."""
    joined: list[str] = []
    for word in arguments:
        if NEGATIVE_NUMBER_PATTERN.match(word) and joined and OPTION_PATTERN.fullmatch(joined[-1]):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def _print_help_and_exit(
    arguments: Sequence[str], commands: Iterable[str], *, overview: str, program: str
) -> NoReturn:
    """Answer --help, --version or an unknown command."""
    parser = argparse.ArgumentParser(
        prog=program,
        usage=f"{program} COMMAND …",
        description="Squeeze-film forces from the Reynolds equation, and empirical models of them.",
        epilog=overview,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"squeezefilm {__version__}")
    if arguments and not arguments[0].startswith("-"):
        hint = _nearest_name_hint(arguments[0], commands)
        parser.error(f"there is no command {arguments[0]!r}; {hint}`{program} --help` names all")
    parser.parse_args(arguments)
    parser.error(f"which command? `{program} --help` names them")


def _option_hint(word: str, known: Sequence[str]) -> str:
    """The options that a word names otherwise, as a hint; empty where it is one, or short for one.

    Args:
        known: the command's own options.
    """
    stem = word.partition("=")[0]
    if stem in known or len([name for name in known if name.startswith(stem)]) == 1:
        return ""
    called = stem.lstrip("-").lower().replace("_", "-")
    own = [name for name, others in SYNONYMS_OF_OPTION.items() if called in (name, *others.split())]
    near = " or ".join(repr(f"--{name}") for name in own if f"--{name}" in known)
    elsewhere = "".join(HINTS_TO_OTHER_COMMANDS.get(name, "") for name in own)
    return f"did you mean {near}? " if near else elsewhere


def _nearest_name_hint(word: str, known: Iterable[str]) -> str:
    import difflib

    near = difflib.get_close_matches(word.lower(), [*known], n=1)
    return f"did you mean {near[0]!r}? " if near else ""


@contextmanager
def _exit_on_interrupt() -> Iterator[None]:
    """Ctrl-C ends the process: a C extension that loads may turn its exception into another."""

    def exit_process(_signal: int, _frame: object) -> None:
        os.write(2, INTERRUPTED_MESSAGE.encode())
        os._exit(130)

    if threading.current_thread() is not threading.main_thread():
        yield  # others get no signals
        return
    before = signal.signal(signal.SIGINT, exit_process)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def overview_text(groups: CommandGroups) -> str:
    """Every command with a line about it, in groups."""
    known = modules_by_command(groups)
    lines = []
    for title, modules in groups.items():
        there = [name for names in modules.values() for name in names.split() if name in known]
        lines += [title] if there else []
        for name in there:
            summary = command_summaries(known[name])[name.replace("-", "_")]
            text = f"  {name:{COMMAND_NAME_WIDTH}}{summary}"
            lines.append(
                textwrap.fill(
                    text, OVERVIEW_WIDTH, subsequent_indent=" " * (COMMAND_NAME_WIDTH + 2)
                )
            )
        lines += [""] if there else []
    return "\n".join([*lines, "`squeezefilm COMMAND --help` explains a command."])
