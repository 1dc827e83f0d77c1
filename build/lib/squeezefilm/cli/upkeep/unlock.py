"""Remove the lock that a killed run of the workflow left in this folder.

Only when every run in it is dead; otherwise ends with status 1 and says who goes on.
"""

import argparse
from pathlib import Path

from squeezefilm.io.errors import RunError
from squeezefilm.runs import locks


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--folder", type=Path, default=Path("."), help="where snakemake runs; here if left out"
    )


def run(options: argparse.Namespace) -> None:
    folder = options.folder.resolve()
    locked = locks.has_snakemake_lock(folder)
    for cards in locks.studies(folder):
        held = locks.is_held(cards)
        if held:
            raise RunError(locks.held_by(cards))
        if held is None and locked:
            raise RunError(
                f"{folder} is locked, and {locks.read_owner(cards)}, which made {cards.parent}, "
                "cannot be asked from here. When you are sure that it is dead, run: "
                "snakemake --unlock"
            )
    if not locked:
        print(f"{folder}: not locked")
        return
    if locks.is_attended(folder):
        raise RunError(f"{folder}: snakemake runs there; wait for it, or end it")
    locks.remove_snakemake_lock(folder)
    print(f"{folder}: removed the lock of a run that is dead")
