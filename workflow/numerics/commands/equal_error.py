"""How many times less processor time the solver takes than other methods at equal error.

  squeezefilm equal-error WORK_PRECISION.csv --output TABLE.csv

One row for each setting of each other method of the work-precision table, for the solver alone
and in a batch.
"""

import argparse

from numerics.equal_error import NEEDED, equal_error
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("table", metavar="WORK_PRECISION.csv")
    parser.add_argument("--output", required=True, metavar="TABLE.csv")


def run(options: argparse.Namespace) -> None:
    table = read_columns(options.table, columns=NEEDED)
    write_table(equal_error(table), options.output)
