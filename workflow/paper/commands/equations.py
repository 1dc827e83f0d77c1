"""Put the paper's study beside the same one with inertia: parameters, errors and designs.

  squeezefilm equations results/paper results/paper-inertia --output T.csv --markdown T.md

Both studies must be made; the tables say whether five points are still enough.
"""

import argparse
from pathlib import Path

from paper.equations import Study, compare, to_markdown
from squeezefilm.io.atomic import write_text
from squeezefilm.io.tables import write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("paper", type=Path, metavar="PAPER", help="results of the paper's study")
    parser.add_argument("inertia", type=Path, metavar="INERTIA", help="and of the one with inertia")
    parser.add_argument("--output", required=True, metavar="TABLE.csv")
    parser.add_argument("--markdown", required=True, metavar="TABLE.md")


def run(options: argparse.Namespace) -> None:
    table = compare(Study(options.paper), Study(options.inertia))
    write_table(table, options.output)
    write_text(to_markdown(table), options.markdown)
