"""One wrong sign or factor in each formula: the tests beside it must find it.

python tests/mutants.py [NAME …] puts each into a copy of the checkout and runs its tests there. A
mutation that no test finds is printed, and the exit status is 1.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
COPIED = ("workflow", "tests", "config", "docs", "pyproject.toml", "README.md")
FOUND, SOUND = 1, 0  # pytest's exit status
# How a test ends that did not get to a number.
NO_NUMBER = ("BUILD_PROGRAM_FAILURE", "SyntaxError", "ImportError")


@dataclass(frozen=True)
class Mutation:
    """A formula made wrong.

    Attributes:
        file: below workflow/squeezefilm.
        sound, wrong: what stands there once, and what is put in its place.
        tests: those that must find it.
    """

    file: str
    sound: str
    wrong: str
    tests: list[str]


MUTATIONS = {
    name: Mutation(**entry)
    for name, entry in yaml.safe_load(
        Path(__file__).with_suffix(".yaml").read_text("utf-8")
    ).items()
}


def run_tests(folder: Path, tests: list[str]) -> tuple[int, str]:
    """Return pytest's exit status in a copy of the checkout, and what it printed."""
    words = ("-q", "-x", "-p", "no:cacheprovider", "--basetemp", str(folder.parent / "pytest"))
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *words, *tests],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout


def outcome(name: str, folder: Path) -> str:
    """Return how the tests of a mutation end without it and with it: ``found``, or what is not."""
    mutation = MUTATIONS[name]
    path = folder / "workflow/squeezefilm" / mutation.file
    text = path.read_text(encoding="utf-8")
    if text.count(mutation.sound) != 1:
        return (
            f"{mutation.file} has {mutation.sound!r} {text.count(mutation.sound)} times, not once"
        )
    status, printed = run_tests(folder, mutation.tests)
    if status != SOUND:
        return f"its tests fail without it:\n{printed[-2000:]}"
    path.write_text(text.replace(mutation.sound, mutation.wrong), encoding="utf-8")
    try:
        status, printed = run_tests(folder, mutation.tests)
    finally:
        path.write_text(text, encoding="utf-8")
    if status == FOUND and not any(word in printed for word in NO_NUMBER):
        return "found"
    return f"NOT FOUND, pytest's exit status is {status}:\n{printed[-2000:]}"


def main(*names: str) -> int:
    if unknown := {*names} - {*MUTATIONS}:
        print(f"{', '.join(sorted(unknown))}: no mutation; there are {', '.join(MUTATIONS)}")
        return 2
    missed = 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "checkout"
        folder.mkdir()
        for part in COPIED:
            copy = shutil.copytree if (ROOT / part).is_dir() else shutil.copy
            copy(ROOT / part, folder / part)
        for name in names or MUTATIONS:
            told = outcome(name, folder)
            missed += told != "found"
            print(f"{name}: {told}", flush=True)
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
