"""Fit a smooth profile to a scan, show its residuals and what its noise does to forces.

    squeezefilm profile --config config/mine.yaml [--forces FORCES.csv] [--table PROFILE.csv]

The profile is the one that every simulation of the study uses. Its noise is drawn anew, from the
residuals, and some of the study's scenes are simulated with each profile that comes out. FORCES.csv
has their forces with the half of the interval that holds the noise's part in 95 % of all scans
(`noise_n`), by what they are low without motion out of phase (`out_of_phase_n`), and the sum of
both (`scan_error_n`), which the solver's own error adds to. PROFILE.csv has the scan's points with
their residuals: `squeezefilm plot profile PROFILE.csv` draws them.
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from squeezefilm.studies.tasks.scan_errors import DRAWS, SEED, scan_report
from squeezefilm.tables import write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--forces", metavar="FORCES.csv", help="forces with other noise")
    parser.add_argument("--table", metavar="PROFILE.csv", help="the scan's points and residuals")
    parser.add_argument("--draws", type=int, default=DRAWS, help="profiles with other noise")
    parser.add_argument("--seed", type=int, default=SEED, help="of the draws")


def run(options: argparse.Namespace) -> None:
    if not 2 <= options.draws <= 10_000:
        raise InputError(f"--draws {options.draws}: a spread needs 2 to 10000 profiles")
    forces, profile, _, text = scan_report(
        load_config(options.config), draws=options.draws, seed=options.seed
    )
    if options.forces:
        write_table(forces, options.forces)
    if options.table:
        write_table(profile, options.table)
    print(text)
