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


Failed = set[tuple[str, str, str]]


def failed_in(table: Path) -> Failed:
    """Part, item and quantity of what failed in the table of a check."""
    rows = pd.read_csv(table, dtype=str, keep_default_na=False).query("verdict == 'failed'")
    return set(rows[["part", "item", "quantity"]].itertuples(index=False, name=None))


@dataclass(frozen=True)
class Checked:
    """A checkout in which the quick study was made and checked, as `make check` does."""

    folder: Path
    status: int
    log: str


@pytest.fixture(scope="session")
def sound(repository, tmp_path_factory):
    """The study as it is."""
    folder = tmp_path_factory.mktemp("sound") / "checkout"
    copy_with_results(repository, folder, REFERENCE)
    for table in folder.glob("results/quick/check/check.*"):
        table.unlink()
    done = snakemake(folder, "check", *QUICK)
    return Checked(folder, done.returncode, done.stdout)


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

    def failed(self) -> Failed:
        """What fails now; the exit status must say so too."""
        output = self.folder / "check.csv"
        config = self.checkout / "config" / "quick.yaml"
        reference = self.checkout / REFERENCE / "quick"
        words = [str(self.folder), f"--config={config}", f"--reference={reference}"]
        status = cli.main(["check", *words, f"--output={output}"])
        failed = failed_in(output)
        assert status == (1 if failed else 0)
        return failed


@pytest.fixture
def results(sound, tmp_path):
    """A copy of the finished results in which a fault may be put."""
    folder = tmp_path / "quick"
    shutil.copytree(sound.folder / "results" / "quick", folder, copy_function=os.link)
    return Results(folder, sound.folder)
