"""Find results that are not as they were made: truncated, corrupted, or edited by hand.

  snakemake --forcerun $(squeezefilm repair)

makes them anew, and what was made from them; `make resume` does so. Each file is compared with its
digest on the run cards. The names of those that differ are written out, and what is in them is kept
under the name with ``.damaged`` added. Files that no card names, and studies that are being made
right now, are left alone.
"""

import argparse
import shutil
import sys
from pathlib import Path

from squeezefilm.io.atomic import digest
from squeezefilm.io.errors import InputError
from squeezefilm.runs import locks
from squeezefilm.runs.run_card import made_files


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--folder", type=Path, default=Path("."), help="where snakemake runs; here if left out"
    )


def run(options: argparse.Namespace) -> None:
    for cards in locks.studies(options.folder):
        if locks.is_held(cards):
            _tell(f"left alone: {locks.held_by(cards)}")
            continue
        last = {made.path: made.sha256 for made in made_files(cards)}
        damaged = [
            name for name, sha256 in last.items() if is_damaged(options.folder / name, sha256)
        ]
        for name in damaged:
            aside = keep_aside(options.folder / name)
            _tell(f"{name} is not as it was made; what is in it is kept as {aside.name}")
            print(name)


def is_damaged(path: Path, sha256: str) -> bool:
    """Whether something else than the file of this digest is there; nothing at all is no damage."""
    return path.exists() and not (path.is_file() and digest(path) == sha256)


def keep_aside(path: Path) -> Path:
    """Give a damaged file a second name, under which it stays when it is made anew.

    Not just another name: Snakemake would not miss a file whose products are there, and leave it.
    A folder, which can have one name only, gets the other one.
    """
    aside = path.with_name(f"{path.name}.damaged")
    try:
        if aside.is_dir():
            shutil.rmtree(aside)
        aside.unlink(missing_ok=True)
        if path.is_dir():
            path.rename(aside)
        else:
            aside.hardlink_to(path)
    except OSError as error:
        raise InputError(f"{aside}: cannot be written: {error.strerror}") from None
    return aside


def _tell(message: str) -> None:
    print(f"squeezefilm: {message}", file=sys.stderr)
