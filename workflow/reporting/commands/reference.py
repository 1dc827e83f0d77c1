"""Make the small reference that `squeezefilm check` compares a study with, from finished results.

  squeezefilm reference results/paper --config config/paper.yaml --output tests/reference/paper

What would change is shown first, cell by cell, and a question asked; --yes answers it.
"""

import argparse
import sys
from pathlib import Path

from reporting.check.compare import Judgement
from reporting.check.pictures import write_pictures
from reporting.check.reference import differences, read_reference, write_reference
from reporting.check.study import study_quantities
from squeezefilm.config.loading import load_config
from squeezefilm.io.errors import RunError

MOST_SHOWN = 60


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="the study's results")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, type=Path, metavar="FOLDER")
    parser.add_argument("--yes", action="store_true", help="overwrite without asking")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    quantities = study_quantities(options.results, config, options.output)
    old = read_reference(options.output) if list(options.output.glob("*.csv")) else {}
    changed = differences(quantities, old)
    if not changed:
        print(f"{options.output}: nothing changes")
        return
    print(_shown(changed))
    if not (options.yes or _confirmed(f"Write {len(changed)} changes to {options.output}?")):
        raise RunError(f"{options.output}: nothing written")
    write_reference(quantities, options.output)
    write_pictures(options.results, options.output)
    print(f"{options.output}: written")


def _shown(changed: list[Judgement]) -> str:
    lines = [
        f"{row.part}, {row.item}, {row.quantity}, {row.worst}: {row.expected} → {row.got}"
        for row in changed[:MOST_SHOWN]
    ]
    more = len(changed) - len(lines)
    return "\n".join([*lines, *([f"… and {more} more"] if more else [])])


def _confirmed(question: str) -> bool:
    """Ask; where nobody can answer, it is a no."""
    if not sys.stdin.isatty():
        print(f"{question} Nobody to ask here: say --yes (YES=1 with make)")
        return False
    return input(f"{question} [y/N] ").strip().lower() in ("y", "yes")
