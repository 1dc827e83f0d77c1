"""One finished run of the quick study, checked against the stored reference, for all faults."""

import os
import shutil
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest

from squeezefilm.cli import main as cli

from ..workflow.conftest import QUICK, copy_checkout, copy_with_results, snakemake

REFERENCE = "tests/reference"
TABLE = "results/quick/check/check.csv"


def read_check(path: Path) -> pd.DataFrame:
    """The table of a check, all its cells but the last column as texts."""
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    return table.assign(of_tolerance=table["of_tolerance"].astype(float))


@dataclass(frozen=True)
class Checked:
    """A checkout in which the quick study was made and checked."""

    folder: Path
    status: int
    log: str

    @property
    def table(self) -> pd.DataFrame:
        return read_check(self.folder / TABLE)

    @property
    def failed(self) -> set[tuple[str, str, str]]:
        """Part, item and quantity of what failed."""
        table = self.table
        rows = table.loc[table["verdict"] == "failed", ["part", "item", "quantity"]]
        return set(rows.itertuples(index=False, name=None))


def run_check(folder: Path, *arguments: str, environment: dict[str, str] | None = None) -> Checked:
    """`snakemake check`, as `make check` calls it."""
    done = snakemake(folder, "check", *QUICK, *arguments, environment=environment)
    return Checked(folder, done.returncode, done.stdout)


@pytest.fixture(scope="session")
def sound(repository, tmp_path_factory):
    """The study as it is."""
    folder = tmp_path_factory.mktemp("sound") / "checkout"
    copy_with_results(repository, folder, REFERENCE)
    shutil.rmtree(folder / "results/quick/check", ignore_errors=True)
    return run_check(folder)


@pytest.fixture
def copy(sound, tmp_path):
    """A copy of the finished checkout in which a fault may be put."""
    more = (REFERENCE, "results", ".snakemake")
    return copy_checkout(sound.folder, tmp_path / "checkout", *more)


@dataclass(frozen=True)
class Results:
    """A copy of the finished results alone, checked by the command line within this process."""

    folder: Path
    checkout: Path

    def failed(self) -> set[tuple[str, str, str]]:
        """Part, item and quantity of what fails now; the exit status must say so too."""
        output = self.folder / "check.csv"
        config = self.checkout / "config" / "quick.yaml"
        reference = self.checkout / REFERENCE / "quick"
        words = [str(self.folder), f"--config={config}", f"--reference={reference}"]
        status = cli.main(["check", *words, f"--output={output}"])
        table = read_check(output)
        rows = table.loc[table["verdict"] == "failed", ["part", "item", "quantity"]]
        assert status == (1 if len(rows) else 0)
        return set(rows.itertuples(index=False, name=None))


@pytest.fixture
def results(sound, tmp_path):
    """A copy of the finished results in which a fault may be put."""
    folder = tmp_path / "quick"
    shutil.copytree(sound.folder / "results" / "quick", folder, copy_function=os.link)
    return Results(folder, sound.folder)
