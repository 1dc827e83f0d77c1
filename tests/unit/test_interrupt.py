"""Ctrl-C ends a command in one line and status 130, wherever it comes."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import pandas as pd
import psutil
import pytest

COMMANDS = {"squeezefilm": "simulate", "squeezefilm_workflow.verification": "random-studies"}


def interrupted(
    words: Sequence[str], folder: Path, *, when: Callable[[psutil.Process], bool]
) -> tuple[int, str]:
    """The status of a command, and all it says, with Ctrl-C on its terminal at some moment."""
    command = subprocess.Popen(
        [sys.executable, "-m", *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    process, until = psutil.Process(command.pid), time.monotonic() + 30
    while command.poll() is None and not when(process) and time.monotonic() < until:
        time.sleep(0.002)
    # A terminal sends it to all processes of the command.
    for each in (process, *process.children(recursive=True)):
        with suppress(psutil.NoSuchProcess):  # the command may have ended it by then
            each.send_signal(signal.SIGINT)
    said, _ = command.communicate(timeout=20)
    return command.returncode, said


def loads_numpy(process: psutil.Process) -> bool:
    return "_multiarray_umath" in Path(f"/proc/{process.pid}/maps").read_text(encoding="utf-8")


@pytest.mark.parametrize("package", COMMANDS)
def test_ctrl_c_while_a_command_is_loaded(repository, package):
    words = [package, COMMANDS[package], "--help"]
    found = interrupted(words, repository / "workflow", when=loads_numpy)
    assert found == (130, "squeezefilm: interrupted\n")


def test_ctrl_c_while_processes_share_the_work(repository, tmp_path):
    solved = {
        "status": "ok",
        "validity": "ok",
        "method": "periodic",
        "domain": "",
        "absent_terms": "",
        "force_error_n": 1e-9,
    }
    work = dict.fromkeys(("nx", "ny", "nt", "newton_steps", "krylov_iterations", "residual"), 1)
    table = pd.read_csv(repository / "tests/reference/four_factor_forces.csv")
    table.assign(**solved, **work).to_csv(tmp_path / "forces.csv", index=False)
    words = (
        f"squeezefilm fit {tmp_path}/forces.csv --model four-factor --processes 2 --seeds 400 "
        f"--config {repository}/config/paper.yaml --output {tmp_path}/fit.json"
    ).split()
    status, said = interrupted(
        words, repository / "workflow", when=lambda process: len(process.children()) == 2
    )
    assert (status, said) == (130, "squeezefilm: interrupted\n")
    assert not (tmp_path / "fit.json").exists()
