"""Remove the lock that a killed run of the workflow left in this folder.

Only where the run that took the lock is dead; otherwise ends with status 1 and says who holds it.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from squeezefilm import locks
from squeezefilm.errors import RunError

SECTIONS: tuple[str, ...] = ()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--folder", type=Path, default=Path("."), help="where snakemake runs; here if left out"
    )


def run(options: argparse.Namespace) -> None:
    if not locks.is_locked(options.folder):
        print(f"{options.folder.resolve()}: not locked")
        return
    owner = locks.read_owner(options.folder)
    by_hand = "When you are sure that it is dead, run: snakemake --unlock"
    if owner is None:
        raise RunError(f"{options.folder.resolve()} is locked by an unknown run. {by_hand}")
    if owner.lives() is None:
        raise RunError(
            f"{options.folder.resolve()} is locked by process {owner.process} on {owner.host}, "
            f"which cannot be asked from here. {by_hand}"
        )
    if owner.lives():
        raise RunError(
            f"{options.folder.resolve()} is locked by process {owner.process}, which still runs; "
            "wait for it, or end it"
        )
    locks.remove_lock(options.folder)
    print(f"{options.folder.resolve()}: removed the lock of process {owner.process}, which is dead")
