"""The code of a command is what Python itself loads for it; its digest is of what decides."""

import subprocess
import sys
from pathlib import Path

import pytest

from squeezefilm.cli.main import commands_of, installed
from squeezefilm.io.errors import InputError
from squeezefilm.runs.code import DECIDES_NOTHING, WORKFLOW, Code

CODE = Code()


@pytest.fixture
def library(tmp_path):
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
            "from squeezefilm.io import job\n"
            "def run():\n    from . import helper\n    from ...late import thing\n"
            "'''A text that speaks of secret.cl and of squeezefilm.other.'''\n"
            "'''secret.cl'''\n"
        ),
        "cli/use/helper.py": "SECTIONS = {'a': ('gas',), 'b': ()}",
        "late.py": "thing = 1",
        "io/__init__.py": "",
        "io/job.py": "import squeezefilm.other",
        "solver/__init__.py": "if False:\n    from squeezefilm import cyclic",
        "solver/core.py": "SOURCES = ('main.cl', '../other/table.yaml')",
        "solver/main.cl": '#include "common.h"\n  #  include <deep.h>\n// secret.cl',
        "solver/common.h": '#include "common.h"',
        "solver/deep.h": "",
        "solver/secret.cl": "",
        "cyclic.py": "import squeezefilm.solver",
        "other.py": "SECTIONS = tuple(range(3))",
        "plugin.py": "from squeezefilm import late\nSECTIONS = ('finger', 'screen')",
        "other/table.yaml": "",
    }
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


def names(library: Path, *words: str) -> set[str]:
    found = Code(library.parent).of(*words)
    return {str(path.relative_to(library.parent)).removeprefix("squeezefilm/") for path in found}


PRESS = {
    "__init__.py",
    "cli/__init__.py",
    "cli/use/__init__.py",
    "cli/use/press.py",
    "cli/use/helper.py",
    "late.py",
    "io/__init__.py",
    "cyclic.py",
    "solver/__init__.py",
    "solver/core.py",
    "solver/main.cl",
    "solver/common.h",
    "solver/deep.h",
    "other/table.yaml",
}


def test_lazy_relative_and_cyclic_imports_and_kernels_are_followed(library):
    assert names(library, "press") == PRESS


def test_a_module_loaded_by_name_is_added(library):
    assert names(library, "helper", "squeezefilm.plugin") == {
        "__init__.py",
        "cli/__init__.py",
        "cli/use/__init__.py",
        "cli/use/helper.py",
        "plugin.py",
        "late.py",
    }


def test_modules_that_are_found_in_a_package_are_followed(library):
    (library / "late.py").write_text("peers = modules_in('squeezefilm.peers')")
    for name in ("__init__.py", "one.py", "two.py", "deep/__init__.py", "deep/three.py"):
        (library / "peers" / name).parent.mkdir(parents=True, exist_ok=True)
        (library / "peers" / name).write_text("")
    found = {name for name in names(library, "press") - PRESS if "deep" not in name}
    assert found == {"peers/__init__.py", "peers/one.py", "peers/two.py"}


def test_what_does_not_exist_is_refused(library):
    with pytest.raises(InputError, match="no command 'pull'"):
        names(library, "pull")
    (library / "late.py").write_text("def")
    with pytest.raises(InputError, match=r"late\.py: line 1"):
        names(library, "press")


def test_sections_are_read_without_running_the_module(library):
    code = Code(library.parent)
    assert code.sections("press") == ("gas", "finger")
    assert code.sections("press", "squeezefilm.plugin") == ("gas", "finger", "screen")
    assert code.sections("press", "squeezefilm.late") == ("gas", "finger")
    assert code.sections("helper", key="a") == ("gas",)
    assert code.sections("helper", key="b") == ()
    assert code.sections("helper", "squeezefilm.late", key="b") == ()
    with pytest.raises(InputError, match="SECTIONS must be a literal"):
        code.sections("helper", key="c")
    (library / "cli/use/press.py").write_text("SECTIONS = tuple(range(3))")
    with pytest.raises(InputError, match="SECTIONS must be a literal"):
        Code(library.parent).sections("press")


BEFORE = '''
"""What it is."""
from typing import TYPE_CHECKING
if TYPE_CHECKING:
    from squeezefilm import other
LIMIT = 1e-6
"""Why."""
def add_arguments(parser):
    """Options."""
    parser.add_argument("--limit", type=float, default=0.5, metavar="L", help="its limit")
def run(x):
    return x * LIMIT  # scaled
'''
LOOKS = {
    "a docstring": ("What it is", "What it was"),
    "a text after a constant": ('"""Why."""', '"""Why not."""'),
    "a comment": ("# scaled", "# once"),
    "a docstring gone": ('    """Options."""\n', ""),
    "a help text": ("its limit", "the limit"),
    "a name of an argument in a help text": ('metavar="L"', 'metavar="LIMIT"'),
    "what type checkers import": ("import other", "import late"),
    "a line broken": ("x * LIMIT", "(\n        x * LIMIT\n    )"),
}
MATTERS = {
    "a number": ("1e-6", "2e-6"),
    "a whole number for a float": ("default=0.5", "default=1"),
    "a default": ("default=0.5", "default=0.6"),
    "an operation": ("x * LIMIT", "x / LIMIT"),
    "a name of an option": ('"--limit"', '"--most"'),
    "an import": ("LIMIT = 1e-6", "from os import path\nLIMIT = 1e-6"),
}
KERNEL = "/* The film. */\n#define N 3\nfloat f(float x) { return x / N; } // by N\n"
CASES = [
    *(("late.py", BEFORE, *edit, True) for edit in LOOKS.values()),
    *(("late.py", BEFORE, *edit, False) for edit in MATTERS.values()),
    ("solver/main.cl", KERNEL, "// by N", "// of N", True),
    ("solver/main.cl", KERNEL, "/* The film. */", "", True),
    ("solver/main.cl", KERNEL, "x / N", "x  /  N", True),
    ("solver/main.cl", KERNEL, "N 3", "N 4", False),
    ("solver/main.cl", KERNEL, "x / N", "x * N", False),
]


@pytest.mark.parametrize(("name", "text", "old", "new", "same"), CASES)
def test_what_decides_changes_the_digest_and_what_only_people_read_does_not(
    library, name, text, old, new, same
):
    assert old in text
    digests = set()
    for each in (text, text.replace(old, new)):
        (library / name).write_text(each)
        digests.add(Code(library.parent).parts[library / name].digest)
    assert (len(digests) == 1) == same


def test_what_is_remembered_is_of_the_same_content(library, tmp_path):
    memory = tmp_path / "code.json"
    first = Code(library.parent, memory=memory)
    assert Code(library.parent, memory=memory).parts == first.parts
    for text in ("thing = 2", "thing = 1"):  # an edit, and it is undone
        (library / "late.py").write_text(text)
        assert Code(library.parent, memory=memory).parts == Code(library.parent).parts
    assert Code(library.parent, memory=memory).sections("helper", key="a") == ("gas",)
    memory.write_text("{")
    assert Code(library.parent, memory=memory).parts == first.parts


COMMANDS = commands_of(installed())
LOADED_BY_EACH = """
import os, sys
import jsonschema, matplotlib.pyplot, pandas, pyopencl, scipy.optimize, scipy.stats  # once
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
def loaded_by_each(repository):
    """The files of ours that a process has loaded when a command has told its options."""
    packages = ("squeezefilm", "verification", "reporting", "paper")
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
def test_every_module_that_a_command_loads_is_among_its_code(command, loaded_by_each):
    nothing = {path for pattern in DECIDES_NOTHING for path in WORKFLOW.glob(pattern)}
    # What the command line loads for any command: names of commands, and how files are written.
    frame = set.intersection(*loaded_by_each.values())
    loaded = loaded_by_each[command]
    assert len(loaded) > 4
    own = WORKFLOW / f"{CODE.command_module(command).replace('.', '/')}.py"
    assert own in loaded
    assert loaded - nothing - frame <= set(CODE.of(command))


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_that_reads_a_study_says_which_sections(command):
    text = Path(CODE.root / f"{COMMANDS[command].replace('.', '/')}.py").read_text("utf-8")
    # Or makes nothing, and shows all of them.
    reads = "load_config(" in text or "study_at(" in text
    assert (reads and command != "config") == ("SECTIONS" in text)
