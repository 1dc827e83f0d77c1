"""Stiff and extreme films, each with a verdict: solved, refused with a true reason, or failed.

  squeezefilm stability --config CONFIG.yaml --output TABLE.csv

Every force is checked by what the solver does not know of: the defect of its pressure on a finer
grid, the mass balance over the period, analytic limits. The exit status is 1 when a case failed;
the table is written nevertheless, and the message names the cases.
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.io.errors import RunError
from squeezefilm.io.tables import write_table
from squeezefilm.studies.solver_settings import device_of
from verification.cases import SAMPLE, cases
from verification.stability import stability

NOTE = "Forces to 1e-4; the checks, columns of the table, are explained in docs/numerics.md."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    full = config["numerics"]["extent"] == "full"
    table = stability(cases() if full else cases()[SAMPLE], device=device_of(config))
    write_table(table.assign(note=NOTE), options.output)
    failed = table[table["verdict"] == "failed"]
    if len(failed):
        named = "; ".join(f"{row.case}: {row.reason}" for row in failed.itertuples())
        raise RunError(f"{len(failed)} of {len(table)} cases failed: {named}")
