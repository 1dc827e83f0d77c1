"""Compare a fitted model with simulated forces: errors point by point, and their summary.

squeezefilm validate FIT.json FORCES.csv --config C.yaml --output ERRORS.csv
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.errors import naming
from squeezefilm.models.fit_file import read_fit
from squeezefilm.studies.tasks.fits import errors_on, limits_of
from squeezefilm.tables import read_ok_forces, write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("forces", metavar="FORCES.csv", help="simulated forces")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="ERRORS.csv", help="error of each point")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    fit, forces = read_fit(options.fit), read_ok_forces(options.forces)
    with naming(f"{options.fit} on {options.forces}"):
        limits = limits_of(forces, config) if fit.force_model.column_names else None
        band = config["validation"]["relative_error_band"]
        table, summary = errors_on(fit, forces, limits=limits, band=band)
    write_table(table, options.output)
    for name, value in summary.items():
        print(f"{name:24}{value:.6g}" if isinstance(value, float) else f"{name:24}{value}")
