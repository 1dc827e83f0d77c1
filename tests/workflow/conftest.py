"""One finished run of the quick study, shared by all tests of the workflow."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).resolve().parent
PARTS = ("Snakefile", "config", "envs", "profiles", "workflow")
QUICK = ("--configfile", "config/quick.yaml")
EVERYTHING = ("paper", "verification", "models", "optimal", "refine", "sweep")


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


def snakemake(
    folder: Path, *arguments: str, environment: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run Snakemake as a user would; standard error is joined to standard output."""
    return subprocess.run(
        [sys.executable, "-m", "snakemake", *arguments],
        cwd=folder,
        env={**os.environ, **(environment or {})},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )


@dataclass(frozen=True)
class Trace:
    """What the process of one job really used."""

    arguments: tuple[str, ...]
    modules: frozenset[Path]
    opened: frozenset[Path]
    sections: frozenset[str]

    @property
    def files(self) -> frozenset[Path]:
        return self.modules | self.opened


@dataclass(frozen=True)
class Finished:
    """A checkout in which the quick study has been run."""

    folder: Path
    log: str
    traces: tuple[Trace, ...]


@pytest.fixture(scope="session")
def finished(repository, tmp_path_factory):
    """The quick study, run from start to end with every process watched."""
    folder = copy_checkout(repository, tmp_path_factory.mktemp("run") / "checkout")
    traces = tmp_path_factory.mktemp("traces")
    done = snakemake(
        folder,
        *EVERYTHING,
        *QUICK,
        environment={"PYTHONPATH": str(HERE / "tracing"), "SQUEEZEFILM_TRACES": str(traces)},
    )
    assert done.returncode == 0, done.stdout[-6000:]
    return Finished(folder, done.stdout, tuple(_read_traces(traces, folder)))


def _read_traces(folder: Path, checkout: Path) -> Iterator[Trace]:
    root = checkout.resolve()
    for path in sorted(folder.glob("*.json")):
        trace: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        files = {
            key: frozenset(
                Path(name).relative_to(root)
                for name in trace[key]
                if Path(name).is_relative_to(root)
            )
            for key in ("modules", "opened")
        }
        # Snakemake's own process loads the library too, to read the configuration.
        if any(path.name == "__main__.py" for path in files["modules"]):
            yield Trace(
                tuple(trace["arguments"]),
                files["modules"],
                files["opened"],
                frozenset(trace["sections"]),
            )


class Planner:
    """Answers which files would be made anew after an edit (see planner.py)."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._process = subprocess.Popen(
            [sys.executable, str(HERE / "planner.py")],
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def rows(
        self, *arguments: str, edits: Mapping[Path, str] | None = None
    ) -> list[dict[str, str]]:
        """Snakemake's summary, a row for each file, after some files were given other texts."""
        question = {
            "edits": {str(path): text for path, text in (edits or {}).items()},
            "arguments": [*arguments, *QUICK],
        }
        assert self._process.stdin
        assert self._process.stdout
        self._process.stdin.write(json.dumps(question) + "\n")
        self._process.stdin.flush()
        rows: list[dict[str, str]] = json.loads(self._process.stdout.readline())
        assert "error" not in rows[0], rows[0]["error"]
        return rows

    def made_anew(self, *arguments: str, edits: Mapping[Path, str] | None = None) -> set[str]:
        """The files that would be made anew."""
        rows = self.rows(*arguments, edits=edits)
        return {row["output_file"] for row in rows if row["plan"] != "no update"}

    def close(self) -> None:
        self._process.communicate()


@pytest.fixture(scope="session")
def planner(finished):
    planner = Planner(finished.folder)
    yield planner
    planner.close()
