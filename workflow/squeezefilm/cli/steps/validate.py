"""Judge a fitted model on sets of simulated forces: errors point by point, and their summary.

  squeezefilm validate FIT.json FORCES.csv --config C.yaml \\
      --output ERRORS.csv --summary ERRORS.json

Several sets are given one after the other, each with its files in the same order. A model that uses
the physics limit needs the LIMITS.csv of each set as --limits.
"""

import argparse
from typing import Any

import pandas as pd

from squeezefilm.config.loading import load_config
from squeezefilm.io.errors import InputError, naming
from squeezefilm.io.positions import as_in
from squeezefilm.io.tables import (
    FACTOR_COLUMNS,
    SCENE_COLUMNS,
    read_ok_forces,
    write_json,
    write_table,
)
from squeezefilm.models.cross_validation import relative_errors, summarise
from squeezefilm.models.data import factors_of
from squeezefilm.models.fit_file import FittedModel, read_fit
from squeezefilm.models.force_model import check_columns


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("forces", nargs="+", metavar="FORCES.csv", help="simulated forces")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    for option, metavar, what in (
        ("--limits", "LIMITS.csv", "physics limits of the same scenes"),
        ("--output", "ERRORS.csv", "error of each point"),
        ("--summary", "ERRORS.json", "all points' errors"),
    ):
        needed = option != "--limits"
        parser.add_argument(option, nargs="+", required=needed, metavar=metavar, help=what)


def run(options: argparse.Namespace) -> None:
    band = load_config(options.config)["validation"]["relative_error_band"]
    fit, sets = read_fit(options.fit), options.forces
    limits = options.limits or [None] * len(sets)
    for option, files in (
        ("--limits", limits),
        ("--output", options.output),
        ("--summary", options.summary),
    ):
        if len(files) != len(sets):
            raise InputError(f"{option}: {len(files)} files for {len(sets)} sets; give one each")
    for forces, limit, output, summary in zip(
        sets, limits, options.output, options.summary, strict=True
    ):
        points = read_ok_forces(forces)
        with naming(f"{options.fit} on {forces}"):
            table, about = _judged(fit, points, limits=limit, band=band)
        write_table(table, output)
        write_json(about, summary)


def _judged(
    fit: FittedModel, forces: pd.DataFrame, *, limits: str | None, band: float
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """The errors on one set of forces: a table of its points, and their summary."""
    model = fit.force_model
    factors = factors_of(forces, limits=limits)
    check_columns(model, factors)
    predicted = model.evaluate(fit.theta, factors)
    simulated = forces["force_n"].to_numpy()
    errors = relative_errors(model_n=predicted, simulation_n=simulated)
    summary = summarise(model_n=predicted, simulation_n=simulated, band=band)
    worst = forces.iloc[summary.pop("worst_index")]
    table = forces[as_in(SCENE_COLUMNS, forces)].assign(
        force_n=simulated, model_n=predicted, relative_error=errors
    )
    return table, {
        **summary,
        "worst_point_id": worst["point_id"],
        **{f"worst_{name}": float(worst[name]) for name in as_in(FACTOR_COLUMNS, forces)},
    }
