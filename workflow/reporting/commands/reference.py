"""Make the small reference that `squeezefilm check` compares a study with, from finished results.

  squeezefilm reference results/paper --output tests/reference/paper

An old reference in the folder is replaced: `git diff` shows what changed, cell by cell.
"""

import argparse
from pathlib import Path

from reporting.check.compare import write_reference
from reporting.check.quantities import study_quantities
from reporting.results import Results


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="the study's results")
    parser.add_argument("--config", metavar="CONFIG.yaml", help="the study, if not RESULTS' own")
    parser.add_argument("--output", required=True, type=Path, metavar="FOLDER")


def run(options: argparse.Namespace) -> None:
    quantities = study_quantities(Results.of(options.results, options.config), options.output)
    write_reference(quantities, options.results, options.output)
    print(f"{options.output}: written")
