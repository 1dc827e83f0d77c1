"""Whatever of a run is killed, going on as `make resume` does ends with the same results."""

import base64
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
# Who is killed during which job of which targets: of a sweep in parts, then of a figure too.
KILLED = (
    ("group", "simulate", ["sweep"]),
    ("snakemake", "fit", ["sweep", "fig08"]),
    ("job", "draw_figures", ["sweep", "fig08"]),
)


def snakemake(*words: str) -> list[str]:
    return [sys.executable, "-m", "snakemake", *words, "--configfile", LONG]


def long_study(folder: Path) -> Path:
    return write_long_study(copy_checkout(CHECKOUT, folder), points=10_000, seconds=1)


def digests(folder: Path) -> dict[str, str]:
    """Every whole file that jobs made, but for run times, with its digest."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.glob("results/**/*"))
        if path.is_file() and "timings" not in path.name and path.suffix != ".part"
    }


def recorded(folder: Path) -> list[Path]:
    """Files of jobs that Snakemake has recorded as finished."""
    made, unfinished = (
        {each.name for each in (folder / ".snakemake" / kind).glob("*")}
        for kind in ("metadata", "incomplete")
    )
    return [folder / base64.urlsafe_b64decode(name).decode() for name in made - unfinished]


def wait_for_job(running: psutil.Popen, command: str) -> psutil.Process:
    """The process of a command of the library, as soon as it runs."""
    while running.poll() is None:
        for job in running.children(recursive=True):
            with contextlib.suppress(psutil.Error):
                if "".join(job.cmdline()[1:2]).endswith(f".{command}.py"):
                    return job
        time.sleep(0.005)
    pytest.fail(f"ended before anything of {command}: {running.returncode}")


def test_a_run_that_is_killed_again_and_again_ends_as_one_that_nothing_befell(tmp_path):
    """And the sweep's forces are the API's."""
    sound, folder = (long_study(tmp_path / name) for name in ("sound", "killed"))
    subprocess.run(snakemake("sweep", "fig08"), cwd=sound, check=True)
    some = read_forces(sound / LONG_FORCES).iloc[::500]
    assert len(some) == 20
    alone = load(sound / LONG).forces(some[list(SCENE_COLUMNS)])
    assert list(alone["force_n"]) == pytest.approx(list(some["force_n"]), rel=1e-12)
    undisturbed = digests(sound)
    finished: list[Path] = []
    times: dict[Path, int] = {}
    for victim, command, targets in KILLED:
        running = psutil.Popen(snakemake(*targets), cwd=folder, start_new_session=True)
        job = wait_for_job(running, command)
        while not finished:
            finished = [path for path in recorded(folder) if path.match("[0-9]*-of-*.parquet")]
        time.sleep(0.3)  # into the job
        jobs = running.children(recursive=True)
        if victim == "group":
            os.killpg(running.pid, signal.SIGKILL)
        else:
            (running if victim == "snakemake" else job).kill()
        assert running.wait(120) != 0
        psutil.wait_procs(jobs, timeout=120)  # or they would write beside the run that follows
        assert digests(folder).items() <= undisturbed.items()
        times = times or {path: path.stat().st_mtime_ns for path in finished}
        subprocess.run(snakemake("--unlock"), cwd=folder, check=True)
    subprocess.run(snakemake(*targets, "--rerun-incomplete"), cwd=folder, check=True)
    assert digests(folder) == undisturbed
    # Nothing is computed twice.
    assert all(path.stat().st_mtime_ns == when for path, when in times.items())
    assert not list(folder.glob("results/**/.*.part"))
