"""A file is whole or not there, whoever else writes it and whatever happens meanwhile."""

import resource
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd
import pytest

from squeezefilm import files
from squeezefilm.errors import InputError
from squeezefilm.files import write_json, write_text
from squeezefilm.table_writer import write_table
from squeezefilm_workflow.reporting.figures import style

TABLE = pd.DataFrame({"point_id": ["1"], "h0_m": [5e-6]})


def draw(path: Path) -> None:
    style.save_figure(plt.figure(figsize=(1, 1)), [path])
    plt.close("all")


WRITERS = {
    "table.csv": lambda path: write_table(TABLE, path),
    "table.parquet": lambda path: write_table(TABLE, path),
    "fit.json": lambda path: write_json({"theta": [1.0]}, path),
    "table.md": lambda path: write_text("text\n", path),
    "figure.png": draw,
    "figure.svg": draw,
}


@pytest.fixture
def full_disk():
    """A function that lets a file have no more than a byte, as a disk that is full, or any size."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)

    def full(yes: bool) -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1, limits[1]) if yes else limits)

    yield full
    full(False)


@pytest.mark.parametrize("name", WRITERS)
def test_a_file_stays_as_it_was_where_another_cannot_be_written(name, tmp_path, full_disk):
    path = tmp_path / name
    path.write_text("before")
    full_disk(True)
    with pytest.raises(InputError, match=f"{name}: cannot be written: .*File too large"):
        WRITERS[name](path)
    full_disk(False)
    assert path.read_text() == "before"
    assert [entry.name for entry in tmp_path.iterdir()] == [name]
    WRITERS[name](path)
    assert path.read_bytes() not in (b"before", b"")
    assert [entry.name for entry in tmp_path.iterdir()] == [name]


def test_a_killed_writer_leaves_the_file_and_a_part_that_is_cleaned_up(repository, tmp_path):
    path = tmp_path / "plan" / "forces.csv"
    write_text("before", path)
    code = (
        "import os, signal; from squeezefilm.files import atomic_file\n"
        f"with atomic_file({str(path)!r}) as part:\n"
        "    part.write_text('half')\n"
        "    os.kill(os.getpid(), signal.SIGKILL)"
    )
    killed = subprocess.run([sys.executable, "-c", code], cwd=repository / "workflow", check=False)
    assert killed.returncode == -9
    assert path.read_text() == "before"
    assert len(list(path.parent.iterdir())) == 2
    files.remove_partial_files(tmp_path)
    assert list(path.parent.iterdir()) == [path]
