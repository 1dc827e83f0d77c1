"""Whatever of a run is killed, going on as `make resume` does ends with the same results."""

import contextlib
import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from squeezefilm import load
from squeezefilm.tables import SCENE_COLUMNS, read_forces

from ..cluster.conftest import LONG, LONG_FORCES, write_long_study
from ..workflow.conftest import copy_checkout

CHECKOUT = Path(__file__).resolve().parents[2]
# A sweep in parts; a plan, its simulation, a fit and a figure.
SNAKEMAKE = (sys.executable, "-m", "snakemake", "sweep", "fig08", "--configfile", LONG)


def digests(folder: Path) -> dict[str, str]:
    """Every whole file that jobs made, but for run times, with its digest."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.glob("results/**/*"))
        if path.is_file() and "timings" not in path.name and path.suffix != ".part"
    }


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The results of a run that nothing befell; the sweep's forces are the API's."""
    new = copy_checkout(CHECKOUT, tmp_path_factory.mktemp("undisturbed"))
    folder = write_long_study(new, points=10_000, seconds=1)
    subprocess.run(SNAKEMAKE, cwd=folder, check=True)
    some = read_forces(folder / LONG_FORCES).iloc[::500]
    assert len(some) == 20
    alone = load(folder / LONG).forces(some[list(SCENE_COLUMNS)])
    assert list(alone["force_n"]) == pytest.approx(list(some["force_n"]), rel=1e-12)
    return digests(folder)


def wait_for_job(running: psutil.Popen, command: str) -> psutil.Process:
    """The process of a command of the library, as soon as it runs."""
    while running.poll() is None:
        for job in running.children(recursive=True):
            with contextlib.suppress(psutil.Error):
                if "".join(job.cmdline()[1:2]).endswith(f".{command}.py"):
                    return job
        time.sleep(0.005)
    pytest.fail(f"ended before anything of {command}: {running.returncode}")


@pytest.mark.parametrize(
    ("victim", "command"),
    [("group", "simulate"), ("snakemake", "fit"), ("job", "draw_figures")],
)
def test_a_killed_run_goes_on(victim, command, undisturbed, tmp_path):
    folder = write_long_study(copy_checkout(CHECKOUT, tmp_path), points=10_000, seconds=1)
    running = psutil.Popen(SNAKEMAKE, cwd=folder, start_new_session=True)
    job = wait_for_job(running, command)
    finished: list[Path] = []
    while command == "simulate" and not finished:
        finished = list(folder.glob("results/**/[0-9]*-of-*.parquet"))
    time.sleep(2 if finished else 0.3)  # until Snakemake knows, too
    if victim == "group":
        os.killpg(running.pid, signal.SIGKILL)
    else:
        (running if victim == "snakemake" else job).kill()
    assert running.wait(120) != 0
    psutil.wait_procs([job], timeout=120)  # or it would write beside the run that follows
    assert digests(folder).items() <= undisturbed.items()
    before = {path: path.stat().st_mtime_ns for path in finished}
    for more in (["--unlock"], ["--rerun-incomplete"]):
        subprocess.run([*SNAKEMAKE, *more], cwd=folder, check=True)
    assert digests(folder) == undisturbed
    # Nothing is computed twice.
    assert all(path.stat().st_mtime_ns == when for path, when in before.items())
    assert not list(folder.glob("results/**/.*.part"))
