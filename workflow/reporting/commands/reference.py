"""Make the small reference that `squeezefilm check` compares a study with, from finished results.

  squeezefilm reference results/paper --output tests/reference/paper

What would change is shown first, cell by cell, and a question asked; --yes answers it.
"""

import argparse
import sys
from pathlib import Path

from reporting.check.compare import differences, read_reference, write_reference
from reporting.check.quantities import study_quantities
from reporting.results import Results
from squeezefilm.errors import RunError

MOST_SHOWN = 60


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="the study's results")
    parser.add_argument("--config", metavar="CONFIG.yaml", help="the study, if not RESULTS' own")
    parser.add_argument("--output", required=True, type=Path, metavar="FOLDER")
    parser.add_argument("--yes", action="store_true", help="overwrite without asking")


def run(options: argparse.Namespace) -> None:
    quantities = study_quantities(Results.of(options.results, options.config), options.output)
    old = read_reference(options.output) if list(options.output.glob("*.csv")) else {}
    changed = differences(quantities, old)
    if not changed:
        print(f"{options.output}: nothing changes")
        return
    print("\n".join(changed[:MOST_SHOWN]))
    if len(changed) > MOST_SHOWN:
        print(f"… and {len(changed) - MOST_SHOWN} more")
    if not (options.yes or _confirmed(f"Write {len(changed)} changes to {options.output}?")):
        raise RunError(f"{options.output}: nothing written")
    write_reference(quantities, options.results, options.output)
    print(f"{options.output}: written")


def _confirmed(question: str) -> bool:
    """Ask; where nobody can answer, it is a no."""
    if not sys.stdin.isatty():
        print(f"{question} Nobody to ask here: say --yes (YES=1 with make)")
        return False
    return input(f"{question} [y/N] ").strip().lower() in ("y", "yes")
