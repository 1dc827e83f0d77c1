"""A Slurm of one's own: munge, slurmctld and slurmd on loopback, in one folder, without systemd."""

import os
import pwd
import secrets
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

DAEMONS = ("munged", "slurmctld", "slurmd")
CLIENTS = (
    *("sbatch", "srun", "squeue", "scancel", "scontrol"),
    *("sinfo", "sacct", "sacctmgr", "sshare"),
)
PARTITION = "loopback"
SYSTEM_PATH = "/usr/sbin:/usr/bin:/sbin:/bin"
USER = pwd.getpwuid(os.getuid()).pw_name
PATIENCE_S = 20

CONFIGURATION = Path(__file__).with_name("slurm.conf.in").read_text("utf-8")


class NoSlurm(Exception):
    """Slurm cannot be had here, and why."""


@dataclass(frozen=True)
class Job:
    """What Slurm's own record says of a job that has ended."""

    number: str
    name: str
    state: str
    partition: str


@dataclass(frozen=True)
class Slurm:
    """A running Slurm; its clients find it through ``environment`` alone."""

    folder: Path
    environment: dict[str, str]

    def run(self, *words: str) -> str:
        """The output of one of Slurm's commands."""
        done = subprocess.run(
            words, env=self.environment, capture_output=True, text=True, check=False, timeout=30
        )
        assert done.returncode == 0, (words, done.stderr)
        return done.stdout

    def running(self) -> list[str]:
        """The numbers of the jobs that run now."""
        return self.run("squeue", "--noheader", "--states=running", "--format=%A").split()

    def ended(self) -> list[Job]:
        """The record of the jobs that have ended, in the order in which they did."""
        path = self.folder / "jobs.txt"
        names = ("JobId", "Name", "JobState", "Partition")
        jobs = []
        for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
            values = dict(word.split("=", 1) for word in line.split() if "=" in word)
            jobs.append(Job(*(values[name] for name in names)))
        return jobs


@contextmanager
def private_slurm() -> Iterator[Slurm]:
    """A Slurm with one node of three processors, stopped in the end with all that it runs.

    Raises:
        NoSlurm: where its programs are missing or do not start.
    """
    if lacking := [name for name in (*DAEMONS, *CLIENTS) if not _program(name)]:
        raise NoSlurm(f"{', '.join(lacking)} not found: apt install slurmctld slurmd slurm-client")
    host = socket.gethostname().split(".")[0]
    if not socket.gethostbyname(host).startswith("127."):
        raise NoSlurm(f"this host's name, {host}, does not stand for a loopback address")
    # munged wants every folder above its socket to be open to others.
    folder = Path(tempfile.mkdtemp(prefix="slurm-", dir="/tmp"))
    folder.chmod(0o755)
    for name in ("state", "spool", "bin"):
        (folder / name).mkdir()
    configuration, key = folder / "slurm.conf", folder / "munge.key"
    ports = dict(zip(("controller_port", "node_port"), _free_ports(2), strict=True))
    configuration.write_text(
        CONFIGURATION.format(host=host, user=USER, folder=folder, partition=PARTITION, **ports)
    )
    key.write_bytes(secrets.token_bytes(1024))
    key.chmod(0o400)
    munge = {"socket": "munge.socket", "key-file": key.name, "log-file": "munged.log"}
    munge |= {"pid-file": "munged.pid", "seed-file": "munged.seed"}
    words = {
        "munged": ["--foreground", *(f"--{name}={folder / file}" for name, file in munge.items())],
        "slurmctld": ["-D", "-c", "-f", str(configuration)],
        "slurmd": ["-D", "-f", str(configuration)],
    }
    slurm = Slurm(folder, _environment(folder, configuration))
    with ExitStack() as stack:
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        for name in DAEMONS:
            stack.callback(_stop, _start(name, words[name], folder, configuration))
        _wait_for_node(slurm)
        yield slurm
        slurm.run("scancel", "--user", USER)


def _program(name: str) -> str | None:
    return shutil.which(name, path=SYSTEM_PATH)


def _free_ports(count: int) -> list[int]:
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


def _environment(folder: Path, configuration: Path) -> dict[str, str]:
    """The environment in which Slurm's commands find this Slurm, also within its jobs.

    A job step drops SLURM_CONF, so the commands are wrapped: without it they would ask a name
    server for a controller.
    """
    for name in CLIENTS:
        wrapper = folder / "bin" / name
        wrapper.write_text(f'#!/bin/sh\nSLURM_CONF={configuration} exec {_program(name)} "$@"\n')
        wrapper.chmod(0o755)
    environment = {key: text for key, text in os.environ.items() if not key.startswith("SLURM")}
    return {**environment, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}


def _start(
    name: str, words: list[str], folder: Path, configuration: Path
) -> subprocess.Popen[bytes]:
    """A daemon in the foreground, as a process of this one."""
    with (folder / f"{name}.log").open("wb") as log:
        return subprocess.Popen(
            [str(_program(name)), *words],
            env={**os.environ, "PATH": SYSTEM_PATH, "SLURM_CONF": str(configuration)},
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
        )


def _stop(daemon: subprocess.Popen[bytes]) -> None:
    daemon.terminate()
    try:
        daemon.wait(timeout=PATIENCE_S)
    except subprocess.TimeoutExpired:
        daemon.kill()
        daemon.wait()


def _wait_for_node(slurm: Slurm) -> None:
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        done = subprocess.run(
            ["sinfo", "--noheader", "--format=%T"],
            env=slurm.environment,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.stdout.strip() == "idle":
            return
        time.sleep(0.1)
    logs = {name: (slurm.folder / f"{name}.log").read_text()[-300:] for name in DAEMONS}
    raise NoSlurm(f"Slurm's node does not come up: {done.stdout} {done.stderr} {logs}")
