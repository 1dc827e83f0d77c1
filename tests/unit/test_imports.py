"""The code of a command is what Python itself loads for it, no less."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

from squeezefilm import imports
from squeezefilm.cli import COMMANDS
from squeezefilm.errors import InputError


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A small library of the same name and layout, with everything that can hide an import."""
    root = tmp_path / "squeezefilm"
    files = {
        "__init__.py": "",
        "__main__.py": "from squeezefilm.cli import main",
        "cli.py": "import importlib",
        "commands/__init__.py": "",
        "commands/press.py": (
            "SECTIONS: tuple[str, ...] = ('gas', 'finger')\n"
            "import squeezefilm.solver.core as core, os.path\n"
            "def run():\n    from . import helper\n    from ..late import thing\n"
            "'''A text that speaks of secret.cl and of squeezefilm.other.'''\n"
        ),
        "commands/helper.py": "SECTIONS = {'a': ('gas',), 'b': ()}",
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
    monkeypatch.setattr(imports, "LIBRARY", root)
    monkeypatch.setattr(imports, "DATA_FOLDERS", (root, tmp_path / "schemas"))
    forget()
    yield root
    forget()


def forget() -> None:
    for name in ("_reached_from", "_named_by", "_all_data", "_parse"):
        getattr(imports, name).cache_clear()


def names(library: Path, *words: str) -> set[str]:
    found = imports.code_of(*words)
    return {str(path.relative_to(library.parent)).removeprefix("squeezefilm/") for path in found}


CORE = {"__init__.py", "__main__.py", "cli.py", "commands/__init__.py"}
PRESS = {
    *CORE,
    "commands/press.py",
    "commands/helper.py",
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
    assert names(library, "helper", "plugin") == CORE | {
        "commands/helper.py",
        "plugin.py",
        "late.py",
    }


def test_what_does_not_exist_is_refused(library: Path) -> None:
    with pytest.raises(InputError, match=r"squeezefilm\.commands\.pull"):
        imports.code_of("pull")
    (library / "late.py").write_text("def")
    with pytest.raises(InputError, match=r"late\.py: line 1"):
        imports.code_of("press")


@pytest.mark.usefixtures("library")
def test_sections_are_read_without_running_the_module() -> None:
    assert imports.sections_of("commands.press") == ("gas", "finger")
    assert imports.sections_of("commands.helper", "a") == ("gas",)
    for module, key in (("commands.helper", "c"), ("other", None), ("late", None)):
        with pytest.raises(InputError, match="SECTIONS must be a literal"):
            imports.sections_of(module, key)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_module_that_a_command_loads_is_among_its_code(
    command: str, library_root: Path
) -> None:
    program = (
        f"import sys; from squeezefilm import cli; import squeezefilm.__main__\n"
        f"try: cli.main([{command!r}, '--help'])\n"
        f"except SystemExit: pass\n"
        f"files = [getattr(m, '__file__', None) for n, m in sys.modules.items()"
        f" if n.partition('.')[0] == 'squeezefilm']\n"
        f"print(*files, sep='\\n', file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=library_root,
        capture_output=True,
        text=True,
        check=True,
    )
    loaded = {Path(line).resolve() for line in done.stderr.splitlines()}
    assert len(loaded) > 4
    assert loaded <= set(imports.code_of(command))


@pytest.fixture(scope="session")
def library_root(repository: Path) -> Path:
    return repository / "workflow"


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_says_which_sections_it_reads(command: str) -> None:
    import importlib

    module: ModuleType = importlib.import_module(
        f"squeezefilm.commands.{command.replace('-', '_')}"
    )
    sections = module.SECTIONS
    for key in sections if isinstance(sections, dict) else [None]:
        expected = tuple(sections if key is None else sections[key])
        assert imports.sections_of(f"commands.{command.replace('-', '_')}", key) == expected
