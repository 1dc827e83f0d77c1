"""Is a finished study the one that was made before? Compare its results with a small reference.

  squeezefilm check results/paper --config config/paper.yaml --reference tests/reference/paper

Compared are figures' data, the paper's tables, claims, simulations, fits, designs, pictures and
the verdicts on stiff films, each as closely as the study's tolerance allows. Shown are each part's
worst quantity and every quantity that failed; all of them are in the table.
The exit status is 1 when anything failed.
"""

import argparse
from pathlib import Path

from reporting.check.compare import compare, to_table
from reporting.check.reference import read_reference
from reporting.check.show import on_screen, status, to_markdown
from reporting.check.study import study_quantities
from squeezefilm.config.loading import load_config
from squeezefilm.io.atomic import write_text
from squeezefilm.io.tables import write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="the study's results")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--reference", required=True, type=Path, metavar="FOLDER")
    parser.add_argument("--output", metavar="CHECK.csv", help="the table, a row each quantity")
    parser.add_argument("--markdown", metavar="CHECK.md", help="the table for people")
    parser.add_argument(
        "--keep-going", action="store_true", help="exit status 0 also when something failed"
    )


def run(options: argparse.Namespace) -> int:
    config = load_config(options.config)
    reference = read_reference(options.reference)
    quantities = study_quantities(options.results, config, options.reference)
    table = to_table(compare(quantities, reference))
    if options.output:
        write_table(table, options.output)
    if options.markdown:
        write_text(to_markdown(table), options.markdown)
    print(on_screen(table))
    return 0 if options.keep_going else status(table)
