"""Say which run made a result: when, with which code, study and versions, on which device.

  squeezefilm trace results/paper/simulations/screen/forces.csv

The file is found by its content, so that a copy under another name or elsewhere is known too. Ends
with status 1 when no run made it, or it was changed since. The device is that of the simulations
that the file was made from.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from squeezefilm.io.atomic import digest
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.runs.run_card import Made, made_files


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="a result, or a copy of one")
    parser.add_argument(
        "--results",
        type=Path,
        default=Path("results"),
        help="folder with the studies and their run cards; ./results if left out",
    )


def run(options: argparse.Namespace) -> None:
    try:
        sha256 = digest(options.file)
    except OSError as error:
        raise InputError(f"{options.file}: cannot be read: {error.strerror}") from None
    made = [
        made for cards in sorted(options.results.glob("*/run_cards")) for made in made_files(cards)
    ]
    path = options.file.resolve()
    here = [one for one in made if Path(one.path).resolve() == path]
    # Equal files are common, such as a plan's one part and the whole: the one asked for, if it is.
    found = [one for one in here if one.sha256 == sha256]
    found = found or [one for one in made if one.sha256 == sha256]
    if not found:
        changed = f"; run {here[-1].run['run']} made another file of this name" if here else ""
        raise RunError(f"{options.file}: no run in {options.results} made this file{changed}")
    print(describe(found[-1], origins=origins(found[-1], made)))


def origins(one: Made, made: Sequence[Made]) -> list[Made]:
    """Files that a file was made from, and those that they were made from, nearest first.

    They are read off the commands: a word, or what follows its ``=``, names a file made before.
    """
    reached: dict[str, Made] = {one.path: one}
    waiting = [one]
    while waiting:
        job = waiting.pop(0).job
        words = {word.rpartition("=")[2] for word in job["command"]}
        for earlier in reversed(made):
            if (
                earlier.path in words
                and earlier.path not in reached
                and earlier.job["ended"] <= job["started"]
            ):
                reached[earlier.path] = earlier
                waiting.append(earlier)
    return list(reached.values())[1:]


def describe(made: Made, *, origins: Sequence[Made]) -> str:
    """Where a file comes from, for people."""
    code = made.run["code"]
    devices = {
        f"{device['device']}, driver {device['driver']}"
        for one in (made, *origins)
        if (device := one.job.get("device"))
    }
    others = {one.run["run"] for one in origins} - {made.run["run"]}
    lines = {
        "file": f"{made.path} (SHA-256 {made.sha256})",
        "made": f"{made.job['ended']} on {made.job['host']}",
        "by": " ".join(made.job["command"]),
        "device": "; ".join(sorted(devices)),
        "threads": ", ".join(f"{key}={value}" for key, value in made.job["threads"].items()),
        "run": f"{made.run['run']} ({made.run['outcome']})",
        "from": f"what runs {', '.join(sorted(others))} made" if others else "",
        "code": f"{code['commit'] or 'not in git'}"
        + (f", with {len(code['changed'])} files changed" if code["dirty"] else "")
        + f" (SHA-256 {code['sha256']})",
        "study": f"{made.run['config']['path']} (SHA-256 {made.run['config']['sha256']})",
        "card": str(made.card),
    }
    return "\n".join(f"{name:<8}{value}" for name, value in lines.items() if value)
