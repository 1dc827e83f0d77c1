"""The film equations on a long strip beside a film with velocity and temperature resolved.

  squeezefilm resolved-strip --config CONFIG.yaml --output TABLE.csv --limits LIMITS.csv

The Reynolds equation, first order in Re, one mode across the gap, and thin-film Navier-Stokes with
and without heat, for gaps of one actuator. LIMITS says up to which Re each is good to 1e-3 and
1e-2.
"""

from __future__ import annotations

import argparse
import sys

import pandas as pd

from numerics.strip.table import FULL, SAMPLE, SIGMA_REYNOLDS, strip_limits, strip_table
from squeezefilm.io.tables import write_table
from squeezefilm.studies.config import load_config

WORDS = {"reynolds": "Reynolds", "first_order": "first order", "one_mode": "one mode"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv")
    parser.add_argument("--limits", required=True, metavar="LIMITS.csv")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    scenes = FULL if config["numerics"]["extent"] == "full" else SAMPLE
    table = strip_table(**scenes, log=lambda text: print(text, file=sys.stderr, flush=True))
    limits = strip_limits(table)
    write_table(table.assign(note=_note(table, limits)), options.output)
    write_table(limits, options.limits)
    print(limits.to_string(index=False))


def _note(table: pd.DataFrame, limits: pd.DataFrame) -> str:
    """What was solved, and up to which Re each equation holds at all of the amplitudes."""
    good = "; ".join(
        f"{words} to 1e-3 for Re ≤ {_least(limits, equation, 1e-3)}, "
        f"to 1e-2 for Re ≤ {_least(limits, equation, 1e-2)}"
        for equation, words in WORDS.items()
    )
    failed = int((~table["status"].isin(["ok", "uncertain"])).sum())
    uncertain = int((table["status"] == "uncertain").sum())
    return (
        "Infinitely long strip, 1 cm wide, under the paper's profile; one actuator in air: "
        f"σ Re = {SIGMA_REYNOLDS:.0f}. Relative to the isothermal film with resolved velocity; at "
        f"every ε shown good are: {good}. Heat, left out or by one mode: from the film with "
        f"resolved temperature. {uncertain} of {len(table)} forces are uncertain by more than "
        f"1e-3, {failed} were not found."
    )


def _least(limits: pd.DataFrame, equation: str, bound: float) -> str:
    of_it = limits[(limits["equation"] == equation) & (limits["against"] == "resolved")]
    return f"{of_it.loc[of_it['bound'] == bound, 'reynolds'].min():.2g}"
