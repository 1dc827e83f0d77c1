"""Processor time of tilted and bulging gaps and of travelling waves beside plain ones.

python -m numerics gap-costs --output TABLE.csv [--films N] [--repeats N] [--tolerance T]

As a user sees it, and beside the plain film on the same part of the finger: what a tilt takes from
the symmetry is the rest. Medians of repeats, all taken by turns in one run.
"""

import argparse

from numerics.any_gap.costs import costs
from squeezefilm.io.tables import write_table
from squeezefilm.reynolds.device import choose_device


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")
    parser.add_argument("--films", type=int, default=16, metavar="N", help="16 if left out")
    parser.add_argument("--repeats", type=int, default=7, metavar="N", help="7 if left out")
    parser.add_argument("--tolerance", type=float, default=1e-4, help="relative")


def run(options: argparse.Namespace) -> None:
    table = costs(
        films=options.films,
        repeats=options.repeats,
        tolerance=options.tolerance,
        device=choose_device(),
    )
    write_table(table, options.output)
    print(table.to_string(index=False))
