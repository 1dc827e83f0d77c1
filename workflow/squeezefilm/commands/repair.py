"""Put results aside that are not as they were made: truncated, corrupted, or edited by hand.

Each file is compared with its digest on the run cards. One that differs gets ``.damaged`` added to
its name, and the next run makes it anew, with what was made from it. Files that no card names, and
studies that are being made right now, are left alone.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from squeezefilm import locks
from squeezefilm.atomic import digest
from squeezefilm.errors import InputError
from squeezefilm.run_card import made_files

SECTIONS: tuple[str, ...] = ()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--folder", type=Path, default=Path("."), help="where snakemake runs; here if left out"
    )


def run(options: argparse.Namespace) -> None:
    for cards in locks.studies(options.folder):
        if locks.is_held(cards):
            print(f"{cards.parent}: left alone: {locks.held_by(cards)}")
            continue
        last = {made.path: made.sha256 for made in made_files(cards)}
        damaged = [
            path
            for path, sha256 in last.items()
            if (options.folder / path).is_file() and digest(options.folder / path) != sha256
        ]
        for path in damaged:
            put_aside(options.folder / path)
        print(f"{cards.parent}: {len(last) - len(damaged)} results are as they were made")


def put_aside(path: Path) -> None:
    """Take a damaged file's name from it."""
    aside = path.with_name(f"{path.name}.damaged")
    try:
        path.replace(aside)
    except OSError as error:
        raise InputError(f"{path}: cannot be renamed: {error.strerror}") from None
    print(f"{path} is not as it was made; it is {aside.name} now")
