"""Checkouts with small studies in the place of the docs', and all commands run there once."""

import re
import shutil
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import pytest

from ..workflow.conftest import copy_with_results
from .commands import MADE, Command, as_run, to_run

FILES = ("Makefile", "README.md", "LICENSE", "docs")
OF_THE_ENVIRONMENT = ("pyproject.toml", "requirements.lock", "requirements-dev.lock")
PACKAGES = Path(sysconfig.get_path("purelib"))
LONGEST_S = 1200
TAIL = 10_000
ASSIGNMENT = re.compile(r"([A-Z]+)=(\S+)")
OWN_STUDIES = re.compile(r"\bmy-|plate|\bFIT\b")
# What a study says of sizes; a default is for results that count.
SIZES = """
error_map: {h0: {levels: 5}, hv: {levels: 5}}
validation: {points: 40}
four_factor_control: {points: 5}
sweep: {points: 30}
fit: {seeds: {two_factor: 1}}
optimal: {candidates: 300}
refine: {candidates: 300}
"""
SMALLER_PLATE = {
    r"levels: 4": "levels: 3",
    r"levels: 6": "levels: 4",
    r"points: 16": "points: 5",
    r"(validation: {points:) \d+": r"\1 40",
    r"\Z": "solver: {tolerance: 1e-2}\n",
}


@dataclass(frozen=True)
class Outcome:
    """How a command ended, and the end of what it printed."""

    status: int
    told: str


def block(page: Path, beginning: str) -> str:
    """The example of a page that begins with a line, as text of its own."""
    lines = re.search(rf"^    {beginning}\n(?:    .*\n)*", page.read_text("utf-8"), re.MULTILINE)
    assert lines, f"{page}: {beginning}"
    return re.sub(r"^    ", "", lines[0], flags=re.MULTILINE)


def edited(path: Path, changes: dict[str, str]) -> None:
    """Replace each pattern, which must be there."""
    text = path.read_text(encoding="utf-8")
    for pattern, new in changes.items():
        text, count = re.subn(pattern, new, text, flags=re.MULTILINE)
        assert count, pattern
    path.write_text(text, encoding="utf-8")


def make_environment(folder: Path) -> None:
    """Make a checkout's own .venv that has the packages of this one: what commands install there
    stays there.
    """
    environment = folder / ".venv"
    venv.create(environment, symlinks=True)
    own = environment / PACKAGES.relative_to(sys.prefix)
    lines = [str(folder / "workflow"), f"import site; site.addsitedir({str(PACKAGES)!r})"]
    (own / "shared.pth").write_text("\n".join(lines) + "\n", encoding="utf-8")
    for script in Path(sys.prefix, "bin").iterdir():
        if (environment / "bin" / script.name).exists():
            continue
        first, _, rest = script.read_bytes().partition(b"\n")
        if first.startswith(b"#!") and b"python" in first:
            first = f"#!{environment}/bin/python".encode()
        copy = environment / "bin" / script.name
        copy.write_bytes(first + b"\n" + rest)
        copy.chmod(0o755)
    for made in (".run", ".dev"):  # newer than the locks: `make` installs nothing
        (environment / made).touch()


def packages_here() -> dict[str, tuple[int, bytes]]:
    """What is installed here: when each package and command was, and where links lead."""
    entries = [*PACKAGES.iterdir(), *Path(sys.prefix, "bin").iterdir()]
    return {
        str(path): (path.stat().st_mtime_ns, path.read_bytes() if path.suffix == ".pth" else b"")
        for path in entries
        if path.name != "__pycache__"
    }


def small_checkout(repository: Path, folder: Path) -> Path:
    """A copy of the checkout in which the docs' studies are small."""
    copy_with_results(repository, folder, *FILES)
    for name in OF_THE_ENVIRONMENT:
        shutil.copy(repository / name, folder / name)
    make_environment(folder)
    (folder / "results").mkdir(exist_ok=True)
    config = folder / "config"
    shutil.copy(config / "quick.yaml", config / "paper.yaml")
    (folder / "sizes.yaml").write_text(SIZES, encoding="utf-8")
    models = block(folder / "docs/how-to/compare-models.md", "models:")
    mine = block(folder / "docs/reference/configuration.md", "study: mine") + models
    (config / "mine.yaml").write_text(mine, encoding="utf-8")
    disc = block(folder / "docs/how-to/levitate.md", "study: disc")
    (folder / "disc.yaml").write_text(disc, encoding="utf-8")
    edited(config / "plate.yaml", SMALLER_PLATE)
    edited(config / "sweep.yaml", {r"(points:) 100000": r"\1 1000"})
    return folder


def run_all(commands: Iterable[Command], folder: Path) -> dict[str, Outcome]:
    """Run commands one after the other, as a reader types them; what is assigned stays."""
    outcomes: dict[str, Outcome] = {}
    found: dict[str, Outcome] = {}
    assigned = ""
    for command in commands:
        typed = as_run(command.text)
        if ASSIGNMENT.fullmatch(typed):
            assigned += f"{typed}; "
        if typed in found:
            outcomes[command.text] = found[typed]
            continue
        if typed.endswith("forces_from_a_colleague.csv --results results"):
            shutil.copy(folder / f"{MADE}/forces.csv", folder / "forces_from_a_colleague.csv")
        try:
            done = subprocess.run(
                ["bash", "-c", f". .venv/bin/activate && {assigned}{typed}"],
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                timeout=LONGEST_S,
                check=False,
            )
            status, told = done.returncode, done.stdout
        except subprocess.TimeoutExpired as end:
            status, told = -1, (end.stdout or b"") + b"\ntook too long"
        found[typed] = Outcome(status, told.decode(errors="replace")[-TAIL:])
        outcomes[command.text] = found[typed]
    return outcomes


@pytest.fixture(scope="session")
def packages_before():
    """What was installed here before the docs' commands ran."""
    return packages_here()


@pytest.fixture(scope="session")
def outcomes(repository, tmp_path_factory, packages_before):
    """How every command ended: those of studies of one's own beside those of the paper's."""
    folder = tmp_path_factory.mktemp("docs")
    own: list[Command] = []
    others: list[Command] = []
    for command in to_run(repository):
        (own if OWN_STUDIES.search(as_run(command.text)) else others).append(command)
    own.sort(key=lambda command: "tutorials" not in command.page)  # where the study is begun
    # The package that it installs takes the place of the checkout, which has the default study.
    others.sort(key=lambda command: command.text.startswith("pip install"))
    with ThreadPoolExecutor(2) as threads:
        chains = [
            threads.submit(run_all, commands, small_checkout(repository, folder / name))
            for name, commands in (("own", own), ("others", others))
        ]
        return {text: outcome for chain in chains for text, outcome in chain.result().items()}
