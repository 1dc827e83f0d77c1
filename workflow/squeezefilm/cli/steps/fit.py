"""Fit an empirical force model to simulated forces, from many seeds.

  squeezefilm fit FORCES.csv --model two-factor --config C.yaml --output FIT.json --runs RUNS.csv

The model is one of the library's or of the study's own (its section `models`). A model that uses
the physics limit needs the table that `squeezefilm limits` wrote, as --limits LIMITS.csv; with
what `squeezefilm limit-table` wrote as --limit-table, its file can be used alone. Where the study's
profile is measured, --scan is the summary that `squeezefilm profile` wrote: what the scan leaves
open is part of the fit's error.

A model of gap and amplitude alone is fitted with the study's `two_factor` seeds, one that knows the
finger's position with its `four_factor` seeds.

Each of the study's bounds and seeds gives one run of the paper's method, a genetic algorithm
followed by Nelder-Mead; one run per bound of SciPy's differential evolution checks them. A model
that is linear in its parameters is solved at once. RUNS.csv has every run, FIT.json the run with
the least sum of squares and all that is needed to use the model: formula, parameters and their
units, ranges of the factors, errors on the points and on points left out, the evidence by which the
model is trusted at a point or not (`squeezefilm predict`), and where it comes from.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm import __version__
from squeezefilm.designs.experiments import check_columns, factors_of
from squeezefilm.io.atomic import digest
from squeezefilm.io.errors import InputError
from squeezefilm.io.parallel import spread
from squeezefilm.io.tables import read_json, read_ok_forces, write_json, write_table
from squeezefilm.models.cross_validation import left_out_predictions
from squeezefilm.models.fit import Fit, fit_by_differential_evolution, fit_model
from squeezefilm.models.fitted import number
from squeezefilm.models.force_model import POLAR, POSITION, ExpressionModel, Factors
from squeezefilm.models.identifiability import check_identifiable
from squeezefilm.models.library import model_named
from squeezefilm.models.trust import Trust, Unseen
from squeezefilm.models.validation import error_sizes
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.study import directions_of

SECTIONS = ("fit", "models", "actuator", "finger")
FOLDS, FOLD_SEED = 5, 1
"""Of the cross-validation that tells a fit's error at points it was not fitted to."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("forces", metavar="FORCES.csv", help="simulated forces")
    parser.add_argument("--model", required=True, metavar="NAME", help="such as two-factor")
    parser.add_argument("--limits", metavar="LIMITS.csv", help="physics limits of the same scenes")
    parser.add_argument("--limit-table", metavar="TABLE.json", help="to put into FIT.json")
    parser.add_argument("--scan", metavar="SUMMARY.json", help="of a measured profile")
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
    config = load_config(options.config).only(SECTIONS)
    model = model_named(options.model, config["models"], place=options.config)
    scan_error = scan_error_of(config, options.scan)
    forces = read_ok_forces(options.forces)
    factors = factors_of(forces, limits=options.limits)
    force_n = forces["force_n"].to_numpy()
    settings = config["fit"]
    if options.seeds is not None:
        settings = settings | {"seeds": dict.fromkeys(settings["seeds"], options.seeds)}
    try:
        check_columns(model, factors)
        if len(factors) >= len(model.parameter_names):
            check_identifiable(model, factors)
        runs = _runs(model, factors, force_n, processes=options.processes, **settings)
        best = min(runs, key=lambda run: run.sum_of_squares)
        about = describe(
            model,
            factors,
            force_n,
            best,
            force_error_n=forces["force_error_n"].to_numpy(),
            scan_error=scan_error,
        )
    except InputError as error:
        if not options.keep_going:
            raise InputError(f"{options.forces}: {error}") from None
        write_json({"model": model.name, "refused": str(error)}, options.output)
        print(error)
        return
    if options.runs:
        write_table(pd.DataFrame([_row(run, model) for run in runs]), options.runs)
    about["directions"] = directions_of(config).to_dict()
    source = {"squeezefilm": __version__, "forces_sha256": digest(Path(options.forces))}
    if options.limits:
        source["limits_sha256"] = digest(Path(options.limits))
    if options.limit_table and model.column_names:
        table = read_json(options.limit_table)
        if "refused" not in table:
            about["limit_table"] = table
    write_json({**best.to_dict(), **about, "source": source}, options.output)


def _runs(
    model: ExpressionModel,
    factors: Factors,
    force_n: np.ndarray,
    *,
    bounds: list[float],
    seeds: dict[str, int],
    first_seed: int,
    processes: int,
) -> list[Fit]:
    """Every seed with every bound, and a differential evolution with every bound as a check."""
    if model.is_linear:
        return [fit_model(model, factors, force_n, bound=bounds[0], seed=first_seed)]
    count = seeds["two_factor" if model.is_centred else "four_factor"]
    all_seeds = range(first_seed, first_seed + count)

    def one(way: tuple[Callable[..., Fit], float, int]) -> Fit:
        function, bound, seed = way
        return function(model, factors, force_n, bound=bound, seed=seed)

    ways = [
        way
        for bound in bounds
        for way in (
            *((fit_model, bound, seed) for seed in all_seeds),
            (fit_by_differential_evolution, bound, first_seed),
        )
    ]
    return spread(one, ways, processes=processes)


def scan_error_of(config: Config, summary: str | None) -> float:
    """The largest share of a force that the scan of the study's profile leaves open, 0 without one.

    Args:
        summary: the file that `squeezefilm profile` wrote.

    Raises:
        InputError: for a study with a scan and no summary, a summary and no scan, or a file that
            is none.
    """
    if config["actuator"]["profile"]["kind"] == "measured":
        if summary is None:
            raise InputError(
                f"{config.path}: its profile is measured; give --scan SUMMARY.json, which "
                "`squeezefilm profile` writes: what the scan leaves open is part of the fit's error"
            )
        return number(read_json(summary), "largest_force_error_share", summary)
    if summary is not None:
        raise InputError(f"--scan {summary}: the profile of {config.path} is not measured")
    return 0.0


def describe(
    model: ExpressionModel,
    factors: Factors,
    force_n: np.ndarray,
    fit: Fit,
    *,
    force_error_n: np.ndarray,
    scan_error: float,
    control: Unseen | None = None,
) -> dict[str, Any]:
    """What a file must tell of a fit, so that the model can be used from the file alone.

    scan_error: share of a force that the scan of a measured profile leaves open.
    control: simulations that were not fitted, to judge the fit by, besides points left out.
    """
    # A model that knows no position was fitted at some all the same.
    position = () if set(model.factor_names) & set(POSITION) else POLAR[:1]
    left_out = _left_out(model, factors, force_n, fit)
    unseen = None
    if left_out is not None:
        unseen = Unseen.of(factors, model_n=left_out, force_n=force_n, force_error_n=force_error_n)
    trust = Trust.of(factors, unseen, scan_error=scan_error)
    return {
        "about": model.about,
        "expression": model.expression,
        "parameters": list(model.parameter_names),
        "parameter_units": list(model.parameter_units),
        "force_unit": "N",
        "ranges": {
            name: [float(np.min(values)), float(np.max(values))]
            for name in (*model.factor_names, *position, *model.column_names)
            for values in [factors.column(name)]
        },
        "residual": error_sizes(model_n=model.evaluate(fit.theta, factors), simulation_n=force_n),
        "cross_validation": None
        if left_out is None
        else {
            "folds": min(FOLDS, len(force_n)),
            **error_sizes(model_n=left_out, simulation_n=force_n),
        },
        "trust": (trust if control is None else trust.with_control(control)).to_dict(),
    }


def _left_out(
    model: ExpressionModel, factors: Factors, force_n: np.ndarray, fit: Fit
) -> np.ndarray | None:
    """Forces at points left out of the fit; none where they are too few to leave any out."""
    count = len(force_n)
    folds = min(FOLDS, count)
    if folds < 2 or count - -(-count // folds) < len(model.parameter_names):
        return None
    predicted = left_out_predictions(
        model, factors, force_n, theta=fit.theta, folds=folds, seed=FOLD_SEED
    )
    return predicted if np.all(np.isfinite(predicted)) else None


def _row(fit: Fit, model: ExpressionModel) -> dict[str, object]:
    """A run as a table's row, a column for each parameter."""
    plain = fit.to_dict()
    theta = dict(zip(model.parameter_names, plain.pop("theta"), strict=True))
    search = {f"search_{k}": v for k, v in zip(theta, plain.pop("search_theta"), strict=True)}
    return {**plain, **theta, **search}
