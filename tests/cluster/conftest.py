"""A Slurm for all tests here, checkouts set up for it, and the same tables made without it."""

import re
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from ..workflow.conftest import copy_checkout, snakemake
from .slurm import PARTITION, NoSlurm, private_slurm

PATIENCE = 600  # seconds until a test gives up waiting; the machine may be busy
QUICK = "config/quick.yaml"
LONG = "config/long.yaml"
LONG_FORCES = "results/long/simulations/sweep/forces.parquet"
QUICK_TABLES = (
    "results/quick/simulations/screen/forces.csv",
    "results/quick/simulations/error_map/forces.csv",
    "results/quick/simulations/four_factor_control/forces.csv",
    "results/quick/simulations/sweep/forces.parquet",
    "results/quick/fits/screen.json",
)
# No accounting on this Slurm, so squeue is asked; jobs last seconds, so they are asked for soon.
ON_SLURM = (
    *("--workflow-profile", "profiles/slurm"),
    *("--slurm-status-command", "squeue"),
    *("--slurm-init-seconds-before-status-checks", "7"),
    *("--latency-wait", "5"),
)


@pytest.fixture(scope="session")
def slurm():
    try:
        with private_slurm() as slurm:
            yield slurm
    except NoSlurm as reason:
        pytest.skip(f"no Slurm: {reason}")


@dataclass
class Run:
    """A snakemake at work, what it says kept in a file."""

    process: subprocess.Popen[bytes]
    log: Path

    @property
    def text(self) -> str:
        return self.log.read_text(encoding="utf-8", errors="replace")

    def succeeds(self) -> None:
        status = self.process.wait(timeout=PATIENCE)
        assert status == 0, self.text[-6000:]

    def submitted(self) -> list[str]:
        """The numbers of the jobs that it has handed to Slurm."""
        pattern = r"(?:SLURM jobid|external jobid) '?(\d+)"
        return re.findall(pattern, self.text)


@dataclass(frozen=True)
class Checkout:
    """A copy of the workflow that Slurm's jobs see too."""

    folder: Path
    environment: dict[str, str]

    def start(self, *arguments: str) -> Run:
        return self._start(sys.executable, "-m", "snakemake", *arguments)

    def on_slurm(self, config: str, targets: Sequence[str]) -> Run:
        return self.start(*targets, "--configfile", config, *ON_SLURM)

    def resume(self, config: str, target: str) -> Run:
        """Go on as docs/how-to/cluster.md says; the environment is that of the tests."""
        venv = self.folder / ".venv"
        venv.symlink_to(sys.prefix)
        options = " ".join((target, *ON_SLURM))
        return self._start(
            *("make", "--old-file", ".venv/.run", "resume"),
            *(f"CONFIG={config}", f"OPTIONS={options}"),
        )

    def _start(self, *command: str) -> Run:
        log = self.folder / f"run-{time.monotonic_ns()}.log"
        with log.open("wb") as handle:
            process = subprocess.Popen(
                command,
                cwd=self.folder,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=handle,
                stderr=subprocess.STDOUT,
            )
        return Run(process, log)


@pytest.fixture
def checkout(slurm, repository):
    """A fresh checkout beside Slurm's files, with the profile set up as a user would."""
    folder = copy_checkout(repository, slurm.folder / f"checkout-{time.monotonic_ns()}", "Makefile")
    write_long_study(folder)
    set_up_profile(folder, scratch=slurm.folder / "scratch")
    return Checkout(folder, slurm.environment)


def write_long_study(folder: Path, *, points: int = 4000, seconds: float = 1000) -> Path:
    """A study with a sweep that runs for several seconds, by default in one job."""
    text = (folder / QUICK).read_text(encoding="utf-8")
    for pattern, new in (
        (r"^study: .*", "study: long"),
        (r"(seconds_per_job:) \S+", rf"\g<1> {seconds}"),
        (r"(sweep:.*\n  points:) \d+", rf"\g<1> {points}"),
    ):
        text, count = re.subn(pattern, new, text, flags=re.MULTILINE)
        assert count == 1, pattern
    (folder / LONG).write_text(text, encoding="utf-8")
    return folder


def set_up_profile(folder: Path, *, scratch: Path) -> None:
    """The lines that docs/how-to/cluster.md asks a user to fill in."""
    path = folder / "profiles/slurm/config.yaml"
    text = path.read_text(encoding="utf-8")
    for name, value in (("slurm_partition", PARTITION), ("tmpdir", str(scratch))):
        text, count = re.subn(rf"# {name}: \S+", f"{name}: {value}", text)
        assert count == 1, name
    path.write_text(text, encoding="utf-8")


@pytest.fixture(scope="session")
def made_locally(repository, tmp_path_factory):
    """What a table holds that was made on this machine without any scheduler."""
    folder = copy_checkout(repository, tmp_path_factory.mktemp("local") / "checkout")
    write_long_study(folder)
    for config, targets in ((QUICK, QUICK_TABLES), (LONG, (LONG_FORCES,))):
        done = snakemake(folder, *targets, "--configfile", config)
        assert done.returncode == 0, done.stdout[-6000:]
    return lambda name: (folder / name).read_bytes()


def wait_until(what: Callable[[], bool], *, of: Run | None = None) -> None:
    """Wait for something to become true, while a run goes on."""
    end = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < end, "nothing happened" + (of.text[-3000:] if of else "")
        assert of is None or of.process.poll() is None, of.text[-6000:]
        time.sleep(0.2)
