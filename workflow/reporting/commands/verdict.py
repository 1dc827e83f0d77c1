"""Show the table of a check, and end with status 1 when anything in it failed.

squeezefilm verdict results/paper/check/check.csv
"""

import argparse
from pathlib import Path

from reporting.check.show import on_screen, read_check, status


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("table", type=Path, metavar="CHECK.csv", help="written by `check`")


def run(options: argparse.Namespace) -> int:
    table = read_check(options.table)
    print(on_screen(table))
    return status(table)
