"""Fit an empirical force model to simulated forces, from many seeds.

  squeezefilm fit FORCES.csv --model two-factor --config C.yaml --output FIT.json --runs RUNS.csv

Each of the study's bounds and seeds gives one run of the paper's method, a genetic algorithm
followed by Nelder-Mead; one run per bound of SciPy's differential evolution checks them. RUNS.csv
has every run, FIT.json the run with the least sum of squares.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import pandas as pd

from squeezefilm.config import load_config
from squeezefilm.errors import InputError
from squeezefilm.fit import Fit, fit_by_differential_evolution, fit_model
from squeezefilm.force_model import ExpressionModel, Factors, get_model
from squeezefilm.parallel import spread
from squeezefilm.tables import FACTOR_COLUMNS, read_ok_forces, write_json, write_table

SECTIONS = ("fit",)
MODELS = ("two-factor", "four-factor")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("forces", metavar="FORCES.csv", help="simulated forces")
    parser.add_argument("--model", required=True, choices=MODELS)
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="FIT.json", help="the best run")
    parser.add_argument("--processes", type=int, default=1, help="to spread the runs over")
    parser.add_argument("--runs", required=True, metavar="RUNS.csv", help="all runs")


def run(options: argparse.Namespace) -> None:
    settings = load_config(options.config).only(SECTIONS)["fit"]
    model = get_model(options.model.replace("-", "_"))
    forces = read_ok_forces(options.forces)
    try:
        runs = _runs(model, forces, processes=options.processes, **settings)
    except InputError as error:
        raise InputError(f"{options.forces}: {error}") from None
    write_table(pd.DataFrame([_row(run, model) for run in runs]), options.runs)
    write_json(min(runs, key=lambda run: run.sum_of_squares).to_dict(), options.output)


def _runs(
    model: ExpressionModel,
    forces: pd.DataFrame,
    *,
    bounds: list[float],
    seeds: dict[str, int],
    first_seed: int,
    processes: int,
) -> list[Fit]:
    """Every seed with every bound, and a differential evolution with every bound as a check."""
    factors = Factors.of(**{name: forces[name] for name in FACTOR_COLUMNS})
    force_n = forces["force_n"].to_numpy()
    all_seeds = range(first_seed, first_seed + seeds[model.name])

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


def _row(fit: Fit, model: ExpressionModel) -> dict[str, object]:
    """A run as a table's row, a column for each parameter."""
    plain = fit.to_dict()
    theta = dict(zip(model.parameter_names, plain.pop("theta"), strict=True))
    search = {f"search_{k}": v for k, v in zip(theta, plain.pop("search_theta"), strict=True)}
    return {**plain, **theta, **search}
