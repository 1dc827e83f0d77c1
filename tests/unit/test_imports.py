"""The code of a command is what Python itself loads for it, no less."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from squeezefilm.cli.main import commands_of, installed
from squeezefilm.io.errors import InputError
from squeezefilm.runs import code as imports


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A small library of the same name and layout, with everything that can hide an import."""
    root = tmp_path / "squeezefilm"
    files = {
        "__init__.py": "",
        "__main__.py": "from squeezefilm.cli.main import main",
        "cli/__init__.py": "",
        "cli/main.py": "import importlib",
        "cli/use/__init__.py": "",
        "cli/use/press.py": (
            "SECTIONS: tuple[str, ...] = ('gas', 'finger')\n"
            "import squeezefilm.solver.core as core, os.path\n"
            "def run():\n    from . import helper\n    from ...late import thing\n"
            "'''A text that speaks of secret.cl and of squeezefilm.other.'''\n"
        ),
        "cli/use/helper.py": "SECTIONS = {'a': ('gas',), 'b': ()}",
        "late.py": "thing = 1",
        "solver/__init__.py": "if False:\n    from squeezefilm import cyclic",
        "solver/core.py": "SOURCES = ('main.cl', '../schemas/table.yaml')",
        "solver/main.cl": '#include "common.h"\n  #  include <deep.h>\n// secret.cl',
        "solver/common.h": '#include "common.h"',
        "solver/deep.h": "",
        "solver/secret.cl": "",
        "cyclic.py": "import squeezefilm.solver",
        "other.py": "SECTIONS = tuple(range(3))",
        "plugin.py": "from squeezefilm import late",
        "../schemas/table.yaml": "",
    }
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    monkeypatch.setattr(imports, "WORKFLOW", tmp_path)
    forget()
    yield root
    forget()


def forget() -> None:
    for name in ("_reached_from", "_named_by", "_all_data", "_packages", "_parse"):
        getattr(imports, name).cache_clear()


def names(library: Path, *words: str) -> set[str]:
    found = imports.code_of(*words)
    return {str(path.relative_to(library.parent)).removeprefix("squeezefilm/") for path in found}


CORE = {"__init__.py", "__main__.py", "cli/__init__.py", "cli/main.py", "cli/use/__init__.py"}
PRESS = {
    *CORE,
    "cli/use/press.py",
    "cli/use/helper.py",
    "late.py",
    "cyclic.py",
    "solver/__init__.py",
    "solver/core.py",
    "solver/main.cl",
    "solver/common.h",
    "solver/deep.h",
    "schemas/table.yaml",
}


def test_lazy_relative_and_cyclic_imports_and_kernels_are_followed(library: Path) -> None:
    assert names(library, "press") == PRESS


def test_a_module_loaded_by_name_is_added(library: Path) -> None:
    assert names(library, "helper", "squeezefilm.plugin") == CORE | {
        "cli/use/helper.py",
        "plugin.py",
        "late.py",
    }


def test_what_does_not_exist_is_refused(library: Path) -> None:
    with pytest.raises(InputError, match="no command 'pull'"):
        imports.code_of("pull")
    (library / "late.py").write_text("def")
    with pytest.raises(InputError, match=r"late\.py: line 1"):
        imports.code_of("press")


@pytest.mark.usefixtures("library")
def test_sections_are_read_without_running_the_module() -> None:
    assert imports.sections_of("squeezefilm.cli.use.press") == ("gas", "finger")
    assert imports.sections_of("squeezefilm.cli.use.helper", "a") == ("gas",)
    for module, key in (
        ("squeezefilm.cli.use.helper", "c"),
        ("squeezefilm.other", None),
        ("squeezefilm.late", None),
    ):
        with pytest.raises(InputError, match="SECTIONS must be a literal"):
            imports.sections_of(module, key)


COMMANDS = commands_of(installed())
LOADED_BY_EACH = """
import os, sys
import jsonschema, matplotlib.pyplot, pandas, pint, pyopencl, scipy.optimize, scipy.stats  # once
from squeezefilm.runs.code import WORKFLOW  # loads nothing that a command does not
ours = lambda: {n for n in sys.modules if n.partition(".")[0] in %r}
for command in sys.argv[1:]:
    if os.fork() == 0:
        from squeezefilm.cli import main
        try:
            main.main([command, "--help"])
        except SystemExit:
            pass
        files = {getattr(sys.modules[name], "__file__", None) for name in ours()}
        print(command, *filter(None, files), sep="\\t", file=sys.stderr, flush=True)
        os._exit(0)
    os.wait()
"""


@pytest.fixture(scope="session")
def loaded_by_each(repository: Path) -> dict[str, set[Path]]:
    """The files of ours that a process has loaded when a command has told its options."""
    packages = ("squeezefilm", "numerics", "reporting", "paper")
    done = subprocess.run(
        [sys.executable, "-c", LOADED_BY_EACH % (packages,), *COMMANDS],
        cwd=repository / "workflow",
        capture_output=True,
        text=True,
        check=True,
    )
    rows = [line.split("\t") for line in done.stderr.splitlines()]
    return {command: {Path(name).resolve() for name in names} for command, *names in rows}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_module_that_a_command_loads_is_among_its_code(
    command: str, loaded_by_each: dict[str, set[Path]]
) -> None:
    # The command line asks every package for the names of its commands.
    lists = {path.parent / "__init__.py" for path in imports.WORKFLOW.glob("*/commands/*.py")}
    lists |= set(imports.WORKFLOW.glob("squeezefilm/cli/*/__init__.py"))
    lists |= {path.parents[1] / "__init__.py" for path in lists}
    loaded = loaded_by_each[command]
    assert len(loaded) > 4
    own = imports.WORKFLOW / f"{imports.command_module(command).replace('.', '/')}.py"
    assert own in loaded
    assert loaded - lists <= set(imports.code_of(command)) | {Path(imports.__file__)}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_says_which_sections_it_reads(command: str) -> None:
    name, _ = COMMANDS[command]
    sections = importlib.import_module(name).SECTIONS
    for key in sections if isinstance(sections, dict) else [None]:
        expected = tuple(sections if key is None else sections[key])
        assert imports.sections_of(name, key) == expected
