"""Smooth a measured vibration profile, and say what its noise does to profile and forces.

    squeezefilm profile --config config/mine.yaml --summary summary.json \\
        --forces forces.csv --figure profile.csv

The profile is the one that every simulation of the study uses. Its noise is drawn anew, from the
residuals, and some of the study's scenes are simulated with each profile that comes out. FORCES.csv
has their forces with the half of the interval that holds the noise's part in 95 % of all scans
(`noise_n`), by what they are low without motion out of phase (`out_of_phase_n`), and the sum of
both (`scan_error_n`), which the solver's own error adds to.
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.film.measured.tables import described, profile_table, summary_of
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import write_json, write_table
from squeezefilm.studies.study import smoothed_scan_of
from squeezefilm.studies.tasks.scan_errors import DRAWS, SEED, errors_in_study


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml")
    parser.add_argument("--summary", required=True, metavar="SUMMARY.json")
    parser.add_argument("--forces", required=True, metavar="FORCES.csv")
    parser.add_argument("--figure", required=True, metavar="FIGURE.csv")
    parser.add_argument("--draws", type=int, default=DRAWS, help="profiles with other noise")
    parser.add_argument("--seed", type=int, default=SEED, help="of the draws")


def run(options: argparse.Namespace) -> None:
    if not 2 <= options.draws <= 10_000:
        raise InputError(f"--draws {options.draws}: a spread needs 2 to 10000 profiles")
    config = load_config(options.config)
    smoothed = smoothed_scan_of(config)
    if smoothed is None:
        kind = config["actuator"]["profile"]["kind"]
        raise InputError(f"{options.config}: actuator.profile: {kind} is not measured")
    forces = errors_in_study(config, smoothed, draws=options.draws, seed=options.seed)
    summary = summary_of(
        smoothed,
        noise=float(forces["noise_share"].max()),
        error=float(forces["scan_error_share"].max()),
    )
    write_table(forces, options.forces)
    text = described(summary)
    table = profile_table(smoothed).assign(
        note="; ".join(" ".join(line.split()) for line in text.splitlines())
    )
    write_table(table, options.figure)
    write_json(summary, options.summary)
    print(text)
