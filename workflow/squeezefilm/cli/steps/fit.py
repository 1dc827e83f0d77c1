"""Fit an empirical force model to simulated forces, from many seeds.

  squeezefilm fit FORCES.csv --model two-factor --config C.yaml --output FIT.json --runs RUNS.csv

The model is one of the library's or of the study's own (its section `models`). A model that uses
the physics limit needs the table that `squeezefilm limits` wrote, as --limits LIMITS.csv; with
what `squeezefilm limit-table` wrote as --limit-table, its file can be used alone. Where the study's
profile is measured, --scan is the summary that `squeezefilm profile` wrote: what the scan leaves
open is part of the fit's error. --sample has the forces of a validation sample (the study's plans
validation_two_factor and validation_four_factor), --sample-limits its limits: without one the fit
is not validated at any point.

A model of gap and amplitude alone is fitted with the study's `two_factor` seeds, one that knows the
finger's position with its `four_factor` seeds.

Each of the study's bounds and seeds gives one run of the paper's method, a genetic algorithm
followed by Nelder-Mead; one run per bound of SciPy's differential evolution checks them. A model
that is linear in its parameters is solved at once. RUNS.csv has every run, FIT.json the run with
the least sum of squares and all that is needed to use the model: formula, parameters and their
units, ranges of the factors, errors on the points and on points left out, the prediction interval
that the validation sample gives (`squeezefilm predict`), and where it comes from.
"""

import argparse
from dataclasses import asdict
from pathlib import Path

import pandas as pd

from squeezefilm import __version__
from squeezefilm.config.loading import load_config
from squeezefilm.io.atomic import digest
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import read_json, read_ok_forces, write_json, write_table
from squeezefilm.models.data import factors_of
from squeezefilm.models.fit_file import described_fit
from squeezefilm.models.fitting import Fit
from squeezefilm.models.force_model import ExpressionModel, model_named
from squeezefilm.studies.study import film_of, symmetry_of
from squeezefilm.studies.tasks.scan_share import scan_error_of
from squeezefilm.studies.tasks.validation_sample import add_sample_options, with_validation


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("forces", metavar="FORCES.csv", help="simulated forces")
    parser.add_argument("--model", required=True, metavar="NAME", help="such as two-factor")
    parser.add_argument("--limits", metavar="LIMITS.csv", help="physics limits of the same scenes")
    parser.add_argument("--limit-table", metavar="TABLE.json", help="to put into FIT.json")
    parser.add_argument("--scan", metavar="SUMMARY.json", help="of a measured profile")
    add_sample_options(parser)
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="FIT.json", help="the best run")
    parser.add_argument("--processes", type=int, default=1, help="to spread the runs over")
    parser.add_argument("--runs", metavar="RUNS.csv", help="all runs")
    parser.add_argument("--seeds", type=int, help="instead of the study's number of seeds")
    parser.add_argument(
        "--keep-going",
        action="store_true",
        help="write into FIT.json why the model cannot be fitted, and exit with 0",
    )


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    model = model_named(options.model, config["models"], place=options.config)
    profile_uncertainty = scan_error_of(config, options.scan)
    forces = read_ok_forces(options.forces)
    factors = factors_of(forces, limits=options.limits)
    settings = config["fit"]
    if options.seeds is not None:
        settings = settings | {"seeds": dict.fromkeys(settings["seeds"], options.seeds)}
    try:
        about, runs = described_fit(
            model,
            factors,
            forces["force_n"].to_numpy(),
            settings=settings,
            profile_uncertainty=profile_uncertainty,
            processes=options.processes,
        )
        about["directions"] = symmetry_of(config).to_dict()
        about["film"] = film_of(config, left_out=forces["left_out"])
        about["source"] = {
            "squeezefilm": __version__,
            "forces_sha256": digest(Path(options.forces)),
        }
        if options.limits:
            about["source"]["limits_sha256"] = digest(Path(options.limits))
        if options.limit_table and model.column_names:
            table = read_json(options.limit_table)
            if "refused" not in table:
                about["limit_table"] = table
        about = with_validation(
            about, config, sample=options.sample, sample_limits=options.sample_limits
        )
    except InputError as error:
        if not options.keep_going:
            raise InputError(f"{options.forces}: {error}") from None
        write_json({"model": model.name, "refused": str(error)}, options.output)
        print(error)
        return
    if options.runs:
        write_table(pd.DataFrame([_row(run, model) for run in runs]), options.runs)
    write_json(about, options.output)


def _row(fit: Fit, model: ExpressionModel) -> dict[str, object]:
    """A run as a table's row, a column for each parameter."""
    plain = asdict(fit)
    theta = dict(zip(model.parameter_names, plain.pop("theta"), strict=True))
    search = {f"search_{k}": v for k, v in zip(theta, plain.pop("search_theta"), strict=True)}
    return {**plain, **theta, **search}
