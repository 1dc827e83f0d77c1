"""One finished run of the quick study, shared by all tests of the workflow."""

import atexit
import csv
import functools
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest

from squeezefilm_workflow.reporting.results import Results

HERE = Path(__file__).resolve().parent
PARTS = ("Snakefile", "config", "envs", "profiles", "workflow")
QUICK = ("--configfile", "config/quick.yaml")
EVERYTHING = ("paper", "models", "optimal", "refine", "sweep")


def copy_checkout(source: Path, target: Path, *more: str) -> Path:
    """What git tracks of the workflow, and more if wanted, with new modification times."""
    target.mkdir(parents=True, exist_ok=True)
    for name in (*PARTS, *more):
        if (source / name).is_dir():
            shutil.copytree(
                source / name,
                target / name,
                copy_function=shutil.copy,
                ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"),
            )
        else:
            shutil.copy(source / name, target / name)
    return target


def copy_with_results(repository: Path, target: Path, *more: str) -> Path:
    """A checkout with what is made of the quick study already; Snakemake makes the rest."""
    folder = copy_checkout(repository, target, *more)
    for name in ("results/quick", ".snakemake/metadata"):
        if (repository / name).is_dir():
            shutil.copytree(repository / name, folder / name)  # with their times
    return folder


@functools.cache
def forks() -> subprocess.Popen[str]:
    """A process that runs Snakemake without loading it each time (see forks.py)."""
    process = subprocess.Popen(
        [sys.executable, str(HERE / "forks.py")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    atexit.register(process.communicate)
    return process


def snakemake(
    folder: Path, *arguments: str, environment: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run Snakemake as a user would; standard error is joined to standard output.

    With an environment it is a process from its start: Python reads some of it there alone.
    """
    if environment:
        return subprocess.run(
            [sys.executable, "-m", "snakemake", *arguments],
            cwd=folder,
            env={**os.environ, **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
    process = forks()
    assert process.stdin
    assert process.stdout
    with tempfile.NamedTemporaryFile(mode="r", encoding="utf-8") as output:
        question = {"folder": str(folder), "arguments": arguments, "output": output.name}
        process.stdin.write(json.dumps({**question, "environment": dict(os.environ)}) + "\n")
        process.stdin.flush()
        status = int(process.stdout.readline())
        return subprocess.CompletedProcess(arguments, status, output.read())


@dataclass(frozen=True)
class Finished:
    """A checkout in which the quick study has been run."""

    folder: Path
    log: str


@pytest.fixture(scope="session")
def finished(repository, tmp_path_factory):
    """The quick study, run to its end."""
    folder = copy_with_results(repository, tmp_path_factory.mktemp("run") / "checkout")
    done = snakemake(folder, *EVERYTHING, *QUICK)
    assert done.returncode == 0, done.stdout[-6000:]
    return Finished(folder, done.stdout)


@dataclass(frozen=True)
class Study:
    """Where the results of a study lie, and its configuration."""

    root: Path
    config: Path

    @property
    def results(self) -> Results:
        return Results.of_folder(self.root, self.config)

    def changed(
        self, folder: Path, file: str, edit: Callable[[pd.DataFrame], pd.DataFrame]
    ) -> Results:
        """The results in another folder, with one table changed."""
        shutil.copytree(self.root, folder, dirs_exist_ok=True)
        edit(pd.read_csv(folder / file)).to_csv(folder / file, index=False)
        return Results.of_folder(folder, self.config)


@pytest.fixture(scope="session")
def study(finished):
    """The quick study's results."""
    return Study(finished.folder / "results/quick", finished.folder / "config/quick.yaml")


def planned(
    folder: Path, *arguments: str, edits: Mapping[Path, str] | None = None
) -> list[dict[str, str]]:
    """Snakemake's summary, a row for each file, with other texts in some files meanwhile."""
    texts = {folder / path: text for path, text in (edits or {}).items()}
    before = {path: path.read_bytes() for path in texts}
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8")
    done = snakemake(folder, "--detailed-summary", "--nolock", *arguments, *QUICK)
    for path, content in before.items():
        path.write_bytes(content)
    assert done.returncode == 0, done.stdout
    table = done.stdout[done.stdout.index("output_file\t") :]
    return list(csv.DictReader(io.StringIO(table), delimiter="\t"))


def made_anew(folder: Path, *arguments: str, edits: Mapping[Path, str] | None = None) -> set[str]:
    """The files that would be made anew after some files were given other texts."""
    rows = planned(folder, *arguments, edits=edits)
    return {row["output_file"] for row in rows if row["plan"] != "no update"}
