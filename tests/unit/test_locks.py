"""One run at a time makes a study, and a lock goes only with its owner."""

import json
import subprocess
import sys
from dataclasses import asdict, replace

import pytest

from squeezefilm.cli.main import main
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.io.job import CURRENT
from squeezefilm.runs import locks


@pytest.fixture
def cards(tmp_path):
    return tmp_path / "results" / "quick" / "run_cards"


@pytest.fixture
def snakemake_lock(tmp_path):
    """The lock that a killed Snakemake leaves."""
    path = tmp_path / locks.SNAKEMAKE_LOCKS / "0.input.lock"
    path.parent.mkdir(parents=True)
    path.touch()
    return path


@pytest.fixture
def another_process(cards, repository):
    """A process that holds the study."""
    code = (
        "import sys; from pathlib import Path; from squeezefilm.runs import locks\n"
        f"held = locks.hold(Path({str(cards)!r}), locks.new_owner())\n"
        "print('held', flush=True); sys.stdin.read()"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        cwd=repository / "workflow",
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.communicate()


def test_a_second_run_is_refused_until_the_first_is_dead(cards, another_process):
    with pytest.raises(RunError, match=f"is being made by process {another_process.pid} on "):
        locks.hold(cards, locks.new_owner())
    assert locks.is_held(cards)
    another_process.kill()
    another_process.wait()
    assert locks.is_held(cards) is False
    locks.hold(cards, locks.new_owner()).close()


def test_a_lock_goes_only_when_its_owner_is_dead(tmp_path, snakemake_lock, another_process, capsys):
    unlock = ["unlock", "--folder", str(tmp_path)]
    assert main(unlock) == 1
    assert f"made by process {another_process.pid}" in capsys.readouterr().err
    assert snakemake_lock.exists()
    another_process.kill()
    another_process.wait()
    assert main(unlock) == 0
    assert "removed the lock of a run that is dead" in capsys.readouterr().out
    assert not snakemake_lock.exists()


def test_a_lock_stays_while_snakemake_runs_that_holds_no_study_yet(
    tmp_path, snakemake_lock, capsys
):
    attended = locks.attend(tmp_path)
    assert attended
    assert main(["unlock", "--folder", str(tmp_path)]) == 1
    assert "snakemake runs there" in capsys.readouterr().err
    attended.close()
    assert main(["unlock", "--folder", str(tmp_path)]) == 0
    assert main(["unlock", "--folder", str(tmp_path)]) == 0
    assert "not locked" in capsys.readouterr().out


def test_a_lock_of_another_host_is_left_to_the_user(tmp_path, cards, snakemake_lock, capsys):
    owner = replace(locks.new_owner(), host="elsewhere")
    locks.hold(cards, owner).close()
    assert json.loads((cards / CURRENT).read_text()) == asdict(owner)
    assert main(["unlock", "--folder", str(tmp_path)]) == 1
    assert "cannot be asked from here" in capsys.readouterr().err
    assert snakemake_lock.exists()


def test_a_study_that_cannot_be_written_is_refused(cards):
    cards.parent.parent.mkdir(parents=True)
    cards.parent.write_text("a file where a folder should be")
    with pytest.raises(InputError, match="cannot be written: Not a directory"):
        locks.hold(cards, locks.new_owner())
