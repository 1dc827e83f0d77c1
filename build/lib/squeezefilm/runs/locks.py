"""Who makes a study: one run at a time, told apart by a lock that the system drops with its owner.

Snakemake locks a folder too, but leaves its lock behind when it is killed, does not say whose it
is, and removes those of others when it ends. So a run holds a lock of the operating system on
``results/STUDY/run_cards/lock`` from its start to its end, however that comes, and writes beside it
who it is.
"""

import fcntl
import json
import os
import platform
import shutil
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO

from squeezefilm.io.atomic import write_text
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.io.job import CURRENT, remembered
from squeezefilm.runs.provenance import timestamp

LOCK = "lock"
SNAKEMAKE_LOCKS = Path(".snakemake") / "locks"
ALIVE = Path(".snakemake") / "alive"


@dataclass(frozen=True)
class Owner:
    """A run of the workflow: its name, its host and process, and when it started (UTC)."""

    run: str
    host: str
    process: int
    started: str

    def __str__(self) -> str:
        return f"process {self.process} on {self.host}, since {self.started}"


def new_owner() -> Owner:
    """This process as a run; runs' names sort by time."""
    host, process, now = platform.node(), os.getpid(), time.time()
    name = f"{time.strftime('%Y%m%dT%H%M%SZ', time.gmtime(now))}-{host}-{process}"
    return Owner(name, host, process, timestamp(now))


def hold(cards: Path, owner: Owner) -> IO[str]:
    """Become the one run that makes a study, until the returned file is closed or this one dies.

    ``cards`` is the study's folder of run cards.
    Raises RunError when another run makes it, saying which. Raises InputError where the folder
    cannot be written.
    """
    try:
        cards.mkdir(parents=True, exist_ok=True)
        handle = (cards / LOCK).open("a")
    except OSError as error:
        raise InputError(f"{cards}: cannot be written: {error.strerror}") from None
    for attempt in range(5):
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:  # for a moment, it may be one who just asks (is_held)
            if attempt == 4:
                handle.close()
                raise RunError(held_by(cards)) from None
            time.sleep(0.1)
        except OSError:  # a file system without such locks: Snakemake's own must do
            break
        else:
            break
    write_text(json.dumps(asdict(owner)) + "\n", cards / CURRENT)
    return handle


def read_owner(cards: Path) -> Owner | None:
    """The run that held a study last; None where none has been noted."""
    try:
        return Owner(**remembered(cards / CURRENT))
    except TypeError:
        return None


def is_held(cards: Path) -> bool | None:
    """Whether a run makes the study now; None where that cannot be told from here."""
    try:
        with (cards / LOCK).open("a") as handle:
            fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except BlockingIOError:
        return True
    except OSError:
        return None
    # Some shared file systems keep such locks to each host.
    owner = read_owner(cards)
    return False if owner is None or owner.host == platform.node() else None


def held_by(cards: Path) -> str:
    """A sentence on who makes a study, and what to do about it."""
    return f"{cards.parent} is being made by {read_owner(cards)}; wait for it, or end it"


def studies(folder: Path) -> Iterator[Path]:
    """The folders of run cards of all studies in a folder."""
    return (path.parent for path in sorted(folder.glob(f"results/*/run_cards/{LOCK}")))


def attend(folder: Path) -> IO[str] | None:
    """Show that this process of Snakemake lives, until the returned file is closed or it dies.

    Any number may do so at once. A run does it before Snakemake locks the folder, and so before
    it holds a study.
    """
    try:
        (folder / ALIVE).parent.mkdir(exist_ok=True)
        handle = (folder / ALIVE).open("a")
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:  # nothing can be written here, or somebody asks just now
        return None
    return handle


def is_attended(folder: Path) -> bool:
    """Whether any process of Snakemake lives in a folder, whatever it does there."""
    try:
        with (folder / ALIVE).open("a") as handle:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


def has_snakemake_lock(folder: Path) -> bool:
    """Whether Snakemake holds, or left behind, a lock on a folder."""
    return any((folder / SNAKEMAKE_LOCKS).glob("*.lock"))


def remove_snakemake_lock(folder: Path) -> None:
    """Remove Snakemake's lock; only right when no run goes on in the folder."""
    with suppress(FileNotFoundError):
        shutil.rmtree(folder / SNAKEMAKE_LOCKS)
