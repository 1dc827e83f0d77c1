"""Is a finished study the one that was made before? Compare its results with a small reference.

  squeezefilm check results/paper --reference tests/reference/paper

Compared are figures' data, the paper's tables, claims, simulations, fits, designs, pictures and
the verdicts on stiff films, each as closely as the study's tolerance allows. Shown are each part's
worst quantity and every quantity that failed; all of them are in the table.
The exit status is 1 when anything failed.
"""

import argparse
from pathlib import Path

from reporting.check.compare import FAILED, compare, on_screen, read_reference
from reporting.check.quantities import study_quantities
from reporting.results import Results
from squeezefilm.tables import write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="the study's results")
    parser.add_argument("--config", metavar="CONFIG.yaml", help="the study, if not RESULTS' own")
    parser.add_argument("--reference", required=True, type=Path, metavar="FOLDER")
    parser.add_argument("--output", metavar="CHECK.csv", help="the table, a row each quantity")


def run(options: argparse.Namespace) -> int:
    results = Results.of(options.results, options.config)
    found = study_quantities(results, options.reference)
    table = compare(found, read_reference(options.reference))
    if options.output:
        write_table(table, options.output)
    print(on_screen(table))
    return int((table["verdict"] == FAILED).any())
