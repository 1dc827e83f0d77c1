"""Stiff and extreme films, each with a verdict: solved, refused with a true reason, or failed.

  squeezefilm stability --config CONFIG.yaml --output TABLE.csv

Every force is checked by what the solver does not know of: the defect of its pressure on a finer
grid, the mass balance over the period, analytic limits, other orders of summation. The exit status
is 1 when a case failed; the table is written nevertheless, and the message names the cases.
"""

import argparse

import pandas as pd

from numerics.stability import cases, explicit_limits, stability
from squeezefilm.io.errors import RunError
from squeezefilm.io.tables import write_table
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of

NOTE = (
    "Relative differences. Chosen method: a limit that the solver took, from the periodic state. "
    "Limit: from the closed form or the linear solve that holds there "
    "(to leading order). Defect: change of the force, and of "
    "the pressure, in one correction on a finer grid. Mass "
    "balance: net over gross mass over the rim in a period. ⟨H³P²⟩: of a piston at rest, from "
    "1 + 3ε²/2. Sums reordered: the same collocation, unfolded or mirrored. Finer "
    "grid: with inertia and under an ellipse, which the others do not know. Single precision: the "
    "same algorithm in float32; lost: no digit is left. Empty: the check does not apply."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    full = config["numerics"]["extent"] == "full"
    device = device_of(config)
    judged = stability(
        [case for case in cases() if full or case.in_sample],
        device=device,
    )
    table = pd.concat([judged, explicit_limits()], ignore_index=True)
    write_table(table.assign(note=NOTE), options.output)
    failed = table[table["verdict"] == "failed"]
    if len(failed):
        named = "; ".join(f"{row.case}: {row.reason}" for row in failed.itertuples())
        raise RunError(f"{len(failed)} of {len(table)} cases failed: {named}")
