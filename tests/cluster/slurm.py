"""A Slurm of one's own: munge, slurmctld and slurmd on loopback, in one folder, without systemd."""

import os
import pwd
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

PACKAGES = ("slurmctld", "slurmd", "slurm-client", "munge")
DAEMONS = ("munged", "slurmctld", "slurmd")
CLIENTS = (
    "sbatch",
    "srun",
    "squeue",
    "scancel",
    "scontrol",
    "sinfo",
    "sacct",
    "sacctmgr",
    "sshare",
)
PARTITION = "loopback"
CPUS = 3
SYSTEM_PATH = "/usr/sbin:/usr/bin:/sbin:/bin"

CONFIGURATION = """\
ClusterName=private
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
SlurmctldPort={controller_port}
SlurmdPort={node_port}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={folder}/munge.socket
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc={folder}/jobs.txt
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=batch_sched_delay=0
EnforcePartLimits=ALL
ReturnToService=2
MinJobAge=300
KillWait=5
SlurmdParameters=config_overrides
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory=16000 State=UNKNOWN
PartitionName={partition} Nodes={host} Default=YES MaxTime=60 State=UP
"""


class NoSlurm(Exception):
    """Slurm cannot be had here, and why."""


@dataclass(frozen=True)
class Job:
    """What Slurm's own record says of a job that has ended."""

    number: str
    name: str
    state: str
    partition: str
    nodes: str


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
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        jobs = []
        for line in text.splitlines():
            values = dict(word.split("=", 1) for word in line.split() if "=" in word)
            jobs.append(
                Job(
                    number=values["JobId"],
                    name=values["Name"],
                    state=values["JobState"],
                    partition=values["Partition"],
                    nodes=values["NodeList"],
                )
            )
        return jobs


@contextmanager
def private_slurm() -> Iterator[Slurm]:
    """A Slurm with one node of three processors, stopped in the end with all that it runs.

    Raises:
        NoSlurm: where its programs are missing and cannot be installed, or do not start.
    """
    _install()
    host = socket.gethostname().split(".")[0]
    _check_host(host)
    # munged wants every folder above its socket to be open to others.
    folder = Path(tempfile.mkdtemp(prefix="slurm-", dir="/tmp"))
    folder.chmod(0o755)
    controller_port, node_port = _free_ports(2)
    (folder / "slurm.conf").write_text(
        CONFIGURATION.format(
            host=host,
            user=pwd.getpwuid(os.getuid()).pw_name,
            folder=folder,
            controller_port=controller_port,
            node_port=node_port,
            cpus=CPUS,
            partition=PARTITION,
        )
    )
    for name in ("state", "spool", "bin"):
        (folder / name).mkdir()
    slurm = Slurm(folder, _environment(folder))
    with ExitStack() as stack:
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        stack.callback(_stop, folder)
        _start(folder)
        _wait_for_node(slurm)
        yield slurm
        slurm.run("scancel", "--user", pwd.getpwuid(os.getuid()).pw_name)


def _install() -> None:
    missing = [name for name in (*DAEMONS, *CLIENTS) if not shutil.which(name, path=SYSTEM_PATH)]
    if not missing:
        return
    if os.getuid() != 0 or not shutil.which("apt-get"):
        raise NoSlurm(f"{', '.join(missing)} not found; install {' '.join(PACKAGES)}")
    # Installed, but not started: this machine may have no systemd, and no configuration either.
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    install = ("apt-get", "install", "--yes", "--no-install-recommends", *PACKAGES)
    for command in (("apt-get", "update"), install):
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if done.returncode:
            raise NoSlurm(f"{' '.join(command)} failed: {done.stderr.strip()[-300:]}")


def _check_host(host: str) -> None:
    try:
        address = socket.gethostbyname(host)
    except OSError as error:
        raise NoSlurm(f"this host's name, {host}, has no address: {error}") from None
    if not address.startswith("127."):
        raise NoSlurm(f"this host's name, {host}, stands for {address}, not for a loopback address")


def _free_ports(count: int) -> list[int]:
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


def _environment(folder: Path) -> dict[str, str]:
    """The environment in which Slurm's commands find this Slurm, also within its jobs.

    A job step drops SLURM_CONF, so the commands are wrapped: without it they would ask a name
    server for a controller.
    """
    for name in CLIENTS:
        wrapper = folder / "bin" / name
        program = shutil.which(name, path=SYSTEM_PATH)
        wrapper.write_text(f'#!/bin/sh\nSLURM_CONF={folder}/slurm.conf exec {program} "$@"\n')
        wrapper.chmod(0o755)
    environment = {key: text for key, text in os.environ.items() if not key.startswith("SLURM")}
    return {**environment, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}


def _start(folder: Path) -> None:
    (folder / "munge.key").write_bytes(secrets.token_bytes(1024))
    (folder / "munge.key").chmod(0o400)
    munged = [
        "munged",
        f"--socket={folder}/munge.socket",
        f"--key-file={folder}/munge.key",
        f"--log-file={folder}/munged.log",
        f"--pid-file={folder}/munged.pid",
        f"--seed-file={folder}/munged.seed",
    ]
    configuration = f"{folder}/slurm.conf"
    for command in (
        munged,
        ["slurmctld", "-c", "-f", configuration],
        ["slurmd", "-f", configuration],
    ):
        environment = {**os.environ, "PATH": SYSTEM_PATH, "SLURM_CONF": configuration}
        done = _run(command, environment=environment)
        if done.returncode:
            raise NoSlurm(f"{command[0]} does not start: {done.stderr.strip()[-500:]}")


def _run(
    command: Sequence[str], *, environment: dict[str, str]
) -> subprocess.CompletedProcess[str]:
    with tempfile.TemporaryFile("w+") as errors:
        # Not a pipe: a daemon would hold its end open.
        done = subprocess.run(
            command,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            check=False,
            timeout=30,
        )
        errors.seek(0)
        return subprocess.CompletedProcess(command, done.returncode, "", errors.read())


def _wait_for_node(slurm: Slurm) -> None:
    for _ in range(100):
        done = subprocess.run(
            ["sinfo", "--noheader", "--format=%T"],
            env=slurm.environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=30,
        )
        if done.stdout.strip() == "idle":
            return
        time.sleep(0.1)
    raise NoSlurm(f"Slurm's node does not come up: {done.stdout} {done.stderr}")


def _stop(folder: Path) -> None:
    """End the daemons of this folder, the last one first, and what they have left."""
    for name in reversed(DAEMONS):
        number = _daemon(folder, name)
        if number is None:
            continue
        os.kill(number, signal.SIGTERM)
        for _ in range(100):
            if _daemon(folder, name) is None:
                break
            time.sleep(0.1)
        else:
            os.kill(number, signal.SIGKILL)


def _daemon(folder: Path, name: str) -> int | None:
    """The process of a daemon, if it is what its pid file says."""
    try:
        number = int((folder / f"{name}.pid").read_text())
        program = Path(f"/proc/{number}/comm").read_text().strip()
    except (OSError, ValueError):
        return None
    return number if program == name else None
