"""Forces by a fitted model, from its file alone.

  squeezefilm predict FIT.json --h0 5um --hv 0.5um:2um:4 --x 1mm
  squeezefilm predict FIT.json --points POINTS.csv --output FORCES.csv

A quantity is a number with its unit, several with commas, or evenly spaced ones as
first:last:count; every combination is a point. POINTS.csv has the columns h0_m, hv_m and, for a
finger off the centre, x_m, y_m or phi_r_m, phi_deg. `force_error_n` is what the model erred by at
points that were left out of its fit (root mean square); --validation gives the summary of
`squeezefilm validate` to take instead. `note` says where a point lies outside the ranges that the
model was fitted on. The noise of a measured profile is in no model's error: `squeezefilm profile`
says it.
"""

from __future__ import annotations

import argparse
import math

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.models.fitted import FittedModel, number, read_fit
from squeezefilm.models.points import (
    add_point_options,
    factors_of_points,
    points_of,
    read_points,
    show_points,
)
from squeezefilm.tables import read_json, write_table

SECTIONS: tuple[str, ...] = ()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("--points", metavar="POINTS.csv", help="points as a table")
    parser.add_argument("--validation", metavar="ERRORS.json", help="the error to expect")
    parser.add_argument("--output", metavar="FORCES.csv", help="table to write, else it is shown")
    add_point_options(parser)


def run(options: argparse.Namespace) -> None:
    fit = read_fit(options.fit)
    if options.points:
        points, place = read_points(options.points), options.points
    else:
        points, place = points_of(options), "predict"
        if not {"h0_m", "hv_m"} <= set(points):
            raise InputError("predict: give --h0 and --hv, or --points")
    factors = factors_of_points(points, place=place)
    force_n = fit.force_model.evaluate(fit.theta, fit.complete(factors))
    table = points.assign(
        force_n=force_n,
        force_error_n=expected_error(fit, options.validation),
        note=[
            "; ".join(filter(None, [each, "" if np.isfinite(force) else "undefined here"]))
            for each, force in zip(fit.outside(factors), force_n, strict=True)
        ],
    )
    if options.output:
        write_table(table, options.output)
    else:
        show_points(table)


def expected_error(fit: FittedModel, validation: str | None) -> float:
    """The error to expect in newtons: a validation's root mean square, else the fit's own."""
    if validation is None:
        return fit.error_n
    values = read_json(validation)
    points = number(values, "points", validation)
    squares = number(values, "sum_of_squares", validation)
    if points < 1 or squares < 0:
        raise InputError(f"{validation}: not the summary of a validation")
    return math.sqrt(squares / points)
