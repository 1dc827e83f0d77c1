"""Fit an empirical force model to simulated forces, from many seeds.

  squeezefilm fit FORCES.csv --model two-factor --config C.yaml --output FIT.json [--runs RUNS.csv]

The model is one of the library's or of the study's own (its section `models`). What a model uses of
the physics limits is computed for the points, and a table of it over the study's space put into
FIT.json. Where the study's profile is measured, what the scan leaves open is part of the fit's
error. --sample has the forces of a validation sample, such as those of the study's plans
validation_two_factor and validation_four_factor: without one the fit is not validated at any point.

A model of gap and amplitude alone is fitted with the study's `two_factor` seeds, one that knows the
finger's position with its `four_factor` seeds. Each of the study's bounds and seeds gives one run
of the paper's method, a genetic algorithm followed by Nelder-Mead; one run per bound of SciPy's
differential evolution checks them. A model that is linear in its parameters is solved at once.
RUNS.csv has every run, FIT.json the run with the least sum of squares and all that is needed to use
the model: formula, parameters and their units, ranges of the factors, errors on the points and on
points left out, and the prediction interval that the sample gives (`squeezefilm predict`).
"""

import argparse
from pathlib import Path

from squeezefilm.config.loading import load_config
from squeezefilm.errors import naming
from squeezefilm.files import digest
from squeezefilm.models.force_model import get_model
from squeezefilm.studies.tasks.fits import fit_to_forces
from squeezefilm.tables import read_forces, read_ok_forces, write_json, write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("forces", metavar="FORCES.csv", help="simulated forces")
    parser.add_argument("--model", required=True, metavar="NAME", help="such as two-factor")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="FIT.json", help="the best run")
    parser.add_argument("--sample", metavar="FORCES.csv", help="forces of a validation sample")
    parser.add_argument("--runs", metavar="RUNS.csv", help="all runs")
    parser.add_argument("--seeds", type=int, help="instead of the study's number of seeds")
    parser.add_argument("--processes", type=int, default=1, help="to spread the runs over")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    model = get_model(options.model, config["models"], place=options.config)
    forces = read_ok_forces(options.forces)
    sample = read_forces(options.sample) if options.sample else None
    with naming(options.forces):
        fit, runs = fit_to_forces(
            model,
            config,
            forces=forces,
            sample=sample,
            seeds=options.seeds,
            processes=options.processes,
            source={"forces_sha256": digest(Path(options.forces))},
        )
    if options.runs:
        write_table(runs, options.runs)
    write_json(fit.to_dict(), options.output)
    print(fit.statement)
