"""Begin a study of your own actuator.

    squeezefilm new my-actuator

writes config/my-actuator.yaml, a study of twenty lines that says what differs from the defaults,
and config/my-actuator.csv, a vibrometer's table to replace by yours. Neither is written if one of
them is there already. Both run as they are; `squeezefilm config` shows every other key:

    snakemake --configfile config/my-actuator.yaml
"""

import argparse
import re
from pathlib import Path

from squeezefilm.errors import InputError
from squeezefilm.files import write_text

EXAMPLES = Path(__file__).resolve().parents[4] / "config"
EXAMPLE = "vibrometer"
LONGEST = 60


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="of the study: a-z, 0-9, - and _")
    parser.add_argument("--folder", default="config", help="where to write; config if left out")


def run(options: argparse.Namespace) -> None:
    name, folder = options.name, Path(options.folder)
    if not re.fullmatch(r"[a-z0-9][a-z0-9_-]*", name) or len(name) > LONGEST:
        raise InputError(
            f"new: {name!r} is no name of a study: it has lower-case letters, digits, - and _, "
            f"begins with a letter or digit and has at most {LONGEST} characters"
        )
    config, scan = folder / f"{name}.yaml", folder / f"{name}.csv"
    for path in (config, scan):
        if path.exists():
            raise InputError(f"{path}: is there already; choose another name, or remove it")
    texts = {config: _renamed(_example("yaml"), name=name), scan: _example("csv")}
    for path, text in texts.items():
        write_text(text, path)
    print(
        f"{config}: the study; change what is yours\n"
        f"{scan}: an example of a vibrometer's table; replace it by yours\n"
        f"Then: snakemake --configfile {config}"
    )


def _renamed(text: str, *, name: str) -> str:
    """The example's text with another study's name."""
    return (
        text.replace(f"{EXAMPLE}.csv", f"{name}.csv")
        .replace(f"study: {EXAMPLE} ", f"study: {name} ", 1)
        .replace(f"results/{EXAMPLE}", f"results/{name}", 1)
        .replace("THIS_FILE", f"config/{name}.yaml", 1)
    )


def _example(suffix: str) -> str:
    path = EXAMPLES / f"{EXAMPLE}.{suffix}"
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{path}: the example cannot be read ({error.strerror}); "
            "`squeezefilm new` needs a checkout of the workflow"
        ) from None
