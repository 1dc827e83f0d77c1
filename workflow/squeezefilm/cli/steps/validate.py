"""Judge a fitted model on simulated forces: errors point by point, and their summary.

  squeezefilm validate FIT.json FORCES.csv --config C.yaml \\
      --output ERRORS.csv --summary ERRORS.json

A model that uses the physics limit needs the forces' LIMITS.csv as --limits.
"""

from __future__ import annotations

import argparse

from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import (
    FACTOR_COLUMNS,
    SCENE_COLUMNS,
    read_ok_forces,
    write_json,
    write_table,
)
from squeezefilm.models.experiments import check_columns, factors_of
from squeezefilm.models.fitted import read_fit
from squeezefilm.models.validation import relative_errors, summarise
from squeezefilm.studies.config import load_config

SECTIONS = ("validation",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("forces", metavar="FORCES.csv", help="simulated forces")
    parser.add_argument("--limits", metavar="LIMITS.csv", help="physics limits of the same scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="ERRORS.csv", help="error of each point")
    parser.add_argument(
        "--summary", required=True, metavar="ERRORS.json", help="all points' errors"
    )


def run(options: argparse.Namespace) -> None:
    settings = load_config(options.config).only(SECTIONS)["validation"]
    fit, forces = read_fit(options.fit), read_ok_forces(options.forces)
    model = fit.force_model
    try:
        factors = factors_of(forces, limits=options.limits)
        check_columns(model, factors)
        predicted = model.evaluate(fit.theta, factors)
        errors = relative_errors(model_n=predicted, simulation_n=forces["force_n"])
        summary = summarise(
            model_n=predicted,
            simulation_n=forces["force_n"],
            band=settings["relative_error_band"],
        ).to_dict()
    except InputError as error:
        raise InputError(f"{options.fit} on {options.forces}: {error}") from None
    worst = forces.iloc[summary.pop("worst_index")]
    table = forces[list(SCENE_COLUMNS)].assign(
        force_n=forces["force_n"], model_n=predicted, relative_error=errors
    )
    write_table(table, options.output)
    write_json(
        {
            **summary,
            "worst_point_id": worst["point_id"],
            **{f"worst_{name}": float(worst[name]) for name in FACTOR_COLUMNS},
        },
        options.summary,
    )
