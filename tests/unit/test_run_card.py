"""Every file can be traced to the run that made it, also when that run was killed."""

import json
import time
from pathlib import Path

import pytest

from squeezefilm.cli.main import main
from squeezefilm.io import job as this_job
from squeezefilm.runs import locks, run_card


@pytest.fixture
def cards(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return Path("results/quick/run_cards")


@pytest.fixture
def start(cards, quick, monkeypatch):
    """Begin a run; the one before is dead."""
    numbers = iter(range(1000))

    def start() -> locks.Owner:
        monkeypatch.delenv(this_job.RUN_VARIABLE, raising=False)
        one = locks.new_owner()
        owner = locks.Owner(f"{next(numbers):03}", one.host, one.process, one.started)
        locks.hold(cards, owner).close()
        run_card.begin(cards, owner, config=quick, command=["snakemake"], cores=2)
        monkeypatch.setenv(this_job.RUN_VARIABLE, str(cards / owner.run))
        return owner

    return start


@pytest.fixture
def job(quick, monkeypatch):
    """A job of the run: a real command, as in a process of its own."""

    def job(*words: str) -> None:
        monkeypatch.setattr(this_job, "notes", {})
        monkeypatch.setattr(this_job, "written", {})
        monkeypatch.setattr(this_job, "started", time.time())
        study = () if words[0] == "gather" else ("--config", str(quick.path))
        assert main([*words, *study]) == 0

    return job


PLAN = ("plan", "screen", "--output", "results/quick/scenes.csv")


def test_a_completed_run_says_what_made_what(cards, start, job, quick):
    owner = start()
    job(*PLAN)
    run_card.end(cards, owner, outcome=run_card.COMPLETED)
    card = json.loads((cards / "000.json").read_text())
    (made,) = card["jobs"]
    assert made["files"] == {"results/quick/scenes.csv": run_card.digest(Path(PLAN[-1]))}
    assert made["command"][:2] == ["plan", "screen"]
    assert made["versions"]["numpy"]
    assert card["outcome"] == "completed"
    assert card["started"] <= made["started"] <= made["ended"] <= card["ended"]
    assert card["hosts"] == [owner.host]
    assert card["host_count"] == 1
    assert card["seeds"]["fit.first_seed"] == 1
    assert card["config"]["sha256"] == run_card.digest(quick.path)
    assert len(card["code"]["sha256"]) == 64
    page = (cards / "000.md").read_text()
    for word in ("completed", "results/quick/scenes.csv", "numpy", "config/quick.yaml"):
        assert word in page


def test_the_card_of_a_killed_run_is_completed_by_the_next(cards, start, job):
    start()
    job(*PLAN)
    assert json.loads((cards / "000.json").read_text())["outcome"] == "running"
    assert [made.path for made in run_card.made_files(cards)] == [PLAN[-1]]  # already then
    start()
    card = json.loads((cards / "000.json").read_text())
    assert card["outcome"] == "killed"
    assert card["jobs"][0]["files"].keys() == {PLAN[-1]}
    assert card["ended"] == card["jobs"][0]["ended"]
    assert not list(cards.glob("*.jobs"))


def test_a_file_is_traced_by_its_content(cards, start, job, capsys):
    for outcome in (run_card.COMPLETED, run_card.FAILED):
        owner = start()
        job(*PLAN)
        run_card.end(cards, owner, outcome=outcome)
    copy = Path("copy.csv")
    copy.write_bytes(Path(PLAN[-1]).read_bytes())
    capsys.readouterr()
    assert main(["trace", "copy.csv"]) == 0
    assert "001 (failed)" in capsys.readouterr().out  # it was made last
    copy.write_text("something else")
    assert main(["trace", "copy.csv"]) == 1
    assert main(["trace", "none.csv"]) == 2
    Path(PLAN[-1]).write_text("something else")
    assert main(["trace", PLAN[-1]]) == 1
    assert "run 001 made another file of this name" in capsys.readouterr().err


def test_a_file_is_traced_to_the_device_of_what_it_was_made_from(cards, start, job, capsys):
    part, forces = "results/quick/part.csv", "results/quick/forces.csv"
    start()
    job(*PLAN)
    job("simulate", PLAN[-1], "--output", part)
    start()
    job("gather", PLAN[-1], part, "--output", forces)
    capsys.readouterr()
    assert main(["trace", forces]) == 0
    told = capsys.readouterr().out
    assert ", driver " in told
    assert "from    what runs 000 made" in told
    assert main(["trace", PLAN[-1]]) == 0
    assert ", driver " not in capsys.readouterr().out


def test_changed_results_are_named_and_kept(cards, start, job, capsys):
    owner = start()
    job(*PLAN)
    run_card.end(cards, owner, outcome=run_card.COMPLETED)
    capsys.readouterr()
    assert main(["repair"]) == 0
    assert capsys.readouterr().out == ""
    whole = Path(PLAN[-1]).read_bytes()
    Path(PLAN[-1]).write_bytes(whole[:-5])
    assert main(["repair"]) == 0
    assert capsys.readouterr().out == f"{PLAN[-1]}\n"
    assert Path(f"{PLAN[-1]}.damaged").read_bytes() == whole[:-5]


def test_by_hand_no_records_are_written(cards, job):
    job(*PLAN)
    assert not cards.exists()
