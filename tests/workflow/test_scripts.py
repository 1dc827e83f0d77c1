"""A script's output goes to the log of its rule; its errors are told on the terminal too."""

import os
from pathlib import Path

import pytest

from squeezefilm.provenance import WORKFLOW_DIR
from squeezefilm_workflow.verification.run_times import paper_run_times

from .conftest import snakemake

RULE = """
config["study_file"] = "{study}"

rule job:
    output: "result.csv"
    log: "logs/job.log"
    threads: 1
    script: "job's script.py"
"""
SCRIPT = """
import os
import subprocess
from squeezefilm.errors import InputError
from squeezefilm_workflow.job import print_result, run_script


def main(snakemake, config):
    print("printed", os.environ["POCL_MAX_PTHREAD_COUNT"])
    subprocess.run(["echo", "by another program"])
    with open(snakemake.output[0], "w") as file:
        file.write("half")
        file.flush()
        {end}


run_script(main, snakemake)
"""

BUFFERED = {"PYTHONUNBUFFERED": ""}
"""The environment of a user: standard output of a script that goes to a file is buffered."""


@pytest.fixture
def run(tmp_path, repository, monkeypatch):
    folder = tmp_path / "Ordner mit Umläuten"
    folder.mkdir()

    def run(end: str, **variables: str) -> tuple[int, str, str, Path]:
        (folder / "Snakefile").write_text(
            RULE.format(study=repository / "config/quick.yaml"), encoding="utf-8"
        )
        (folder / "job's script.py").write_text(SCRIPT.format(end=end), encoding="utf-8")
        path = os.pathsep.join([str(WORKFLOW_DIR), os.environ.get("PYTHONPATH", "")])
        for name, value in {"PYTHONPATH": path, **BUFFERED}.items():
            monkeypatch.setenv(name, value)
        done = snakemake(folder, "--cores", "1", environment=variables)
        log = (folder / "logs/job.log").read_text(encoding="utf-8")
        return done.returncode, done.stdout, log, folder / "result.csv"

    return run


def test_all_that_a_script_prints_goes_to_its_log(run):
    status, terminal, log, result = run("pass")
    assert status == 0
    assert log.startswith("printed 1\nby another program\nUsed: ")
    used = paper_run_times(result.parent / "logs").iloc[0]
    assert (used["rule"], used["jobs"]) == ("job", 1)
    assert used["processor time (s)"] > 0.1
    assert "printed" not in terminal
    assert result.read_text() == "half"


def test_a_result_that_people_wait_for_is_told_on_the_terminal_too(run):
    """`snakemake profile` ends with the summary that the tutorial shows, on any terminal."""
    ascii_only = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    status, terminal, log, _ = run("print_result('noise  ± 1.6 µm')", **ascii_only)
    assert status == 0
    assert terminal.count("noise  +/- 1.6 um") == log.count("noise  +/- 1.6 um") == 1


@pytest.mark.parametrize(
    ("end", "last", "traceback"),
    [
        ("raise InputError('film.yaml: gap: too thin')", "squeezefilm: error: film.yaml: gap", 0),
        ("1 / 0", "ZeroDivisionError: division by zero", 1),
    ],
)
def test_an_error_is_told_in_a_line_and_leaves_no_output(end, last, traceback, run):
    status, terminal, log, result = run(end)
    assert status != 0
    assert terminal.count(last) == 1
    assert log.count(last) == 1
    assert log.count("Traceback") == traceback
    assert "Traceback" not in terminal
    assert not result.exists()
