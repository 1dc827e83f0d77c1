"""Snakemake's lock on a working directory, and who holds it.

Snakemake locks a directory while it runs and leaves the lock behind when it is killed, but does
not say whose it is. The workflow therefore notes host and process when it starts.
"""

from __future__ import annotations

import json
import platform
import shutil
from dataclasses import asdict, dataclass
from pathlib import Path

LOCKS = Path(".snakemake") / "locks"
OWNER = Path(".snakemake") / "owner.json"


@dataclass(frozen=True)
class Owner:
    """A run of the workflow: its host, its process, and when that process started (epoch)."""

    host: str
    process: int
    started: float

    def lives(self) -> bool | None:
        """Whether the run still goes on; None where that cannot be told from this host."""
        import psutil

        if self.host != platform.node():
            return None
        try:
            # A process number is used again in time: the same start tells the same process.
            return abs(psutil.Process(self.process).create_time() - self.started) < 2
        except psutil.NoSuchProcess:
            return False
        except psutil.AccessDenied:
            return True


def record_owner(folder: Path) -> None:
    """Note that this process runs the workflow in a folder."""
    import psutil

    own = psutil.Process()
    owner = Owner(platform.node(), own.pid, own.create_time())
    path = folder / OWNER
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(asdict(owner)) + "\n", encoding="utf-8")


def read_owner(folder: Path) -> Owner | None:
    """The run that started last in a folder; None where none has been noted."""
    try:
        return Owner(**json.loads((folder / OWNER).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def is_locked(folder: Path) -> bool:
    """Whether Snakemake holds, or left behind, a lock on a folder."""
    return any((folder / LOCKS).glob("*.lock"))


def remove_lock(folder: Path) -> None:
    """Remove the lock; only right when the run that took it is dead."""
    shutil.rmtree(folder / LOCKS, ignore_errors=True)
