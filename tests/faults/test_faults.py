"""Whatever of a run is killed, going on as `make resume` does ends with the same results."""

import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from ..workflow.conftest import QUICK, copy_checkout

CHECKOUT = Path(__file__).resolve().parents[2]
# A plan, its simulation, a fit and two figures, one of which is drawn beside the simulation.
SNAKEMAKE = (sys.executable, "-m", "snakemake", "fig07", "fig08", *QUICK)


def digests(folder: Path) -> dict[str, str]:
    """Every file that jobs made, but for run times, with its digest."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.glob("results/**/*"))
        if path.is_file() and "timings" not in path.name
    }


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The results of a run that nothing befell."""
    folder = copy_checkout(CHECKOUT, tmp_path_factory.mktemp("undisturbed"))
    subprocess.run(SNAKEMAKE, cwd=folder, check=True)
    return digests(folder)


def wait_for_job(running: psutil.Popen, command: str) -> psutil.Process:
    """The process of a command of the library, as soon as it runs."""
    while running.poll() is None:
        for job in running.children(recursive=True):
            try:
                words = job.cmdline()
            except psutil.Error:
                continue
            if words[3:4] == [command] or (words[1:] and words[1].endswith(f".{command}.py")):
                return job
        time.sleep(0.005)
    pytest.fail(f"ended before anything of {command}: {running.returncode}")


@pytest.mark.parametrize(
    ("victim", "command"),
    [("group", "draw_figures"), ("snakemake", "simulate"), ("job", "fit")],
)
def test_a_killed_run_goes_on(victim, command, undisturbed, tmp_path):
    folder = copy_checkout(CHECKOUT, tmp_path)
    with (folder / "killed.log").open("w") as log:
        running = psutil.Popen(
            SNAKEMAKE, cwd=folder, stdout=log, stderr=log, start_new_session=True
        )
        job = wait_for_job(running, command)
        time.sleep(0.3)
        if victim == "group":
            os.killpg(running.pid, signal.SIGKILL)
        else:
            (running if victim == "snakemake" else job).kill()
        assert running.wait(120) != 0
        psutil.wait_procs([job], timeout=120)  # or it would write beside the run that follows
    assert digests(folder).items() <= undisturbed.items()
    for more in (["--unlock"], ["--rerun-incomplete"]):
        done = subprocess.run(
            [*SNAKEMAKE, *more], cwd=folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
    assert digests(folder) == undisturbed
    assert not list(folder.glob("results/**/.*.part"))
