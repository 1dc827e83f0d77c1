"""Forces by a fitted model, from its file alone.

  squeezefilm predict FIT.json --h0 5um --hv 0.5:2:4um --x 1mm
  squeezefilm predict FIT.json --points POINTS.csv --output FORCES.csv

A quantity is a number with its unit, several with commas, or evenly spaced ones as
first:last:count; every combination is a point. POINTS.csv has the columns h0_m, hv_m and, for a
finger off the centre, x_m, y_m or phi_r_m, phi_deg; by the symmetry of the study that the model
was fitted in, any direction may be asked. `error_95_n` is the error that 95 % of new points drawn
uniformly from the study's declared space do not exceed, `error_99_n` the same for 99 %, measured on
a validation sample of simulations that no fit used. Outside the declared space, and for a fit
without such a sample, both are empty and `note` says so. Where the profile was measured, both
contain the uncertainty of its scan, `profile_uncertainty_percent` of the force. `validity` is
`ok`, or the limits of validity of the film equation that a point exceeds; one point by options
outside them is shown with exit status 1.
"""

import argparse
from pathlib import Path

import pandas as pd

from squeezefilm.api.fit import Fit
from squeezefilm.api.points import COLUMNS as FACTORS
from squeezefilm.cli.options import add_point_options, points_in, write_points
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.validity import OK
from squeezefilm.models.data import COLUMNS
from squeezefilm.models.fit_file import FILM_UNKNOWN
from squeezefilm.tables import read_columns


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("--points", metavar="POINTS.csv", help="points as a table")
    parser.add_argument("--output", metavar="FORCES.csv", help="table to write, else it is shown")
    add_point_options(parser)


def run(options: argparse.Namespace) -> None:
    fit = Fit.read(options.fit)
    if options.points:
        points, place = read_points(options.points), options.points
    else:
        points, place = points_in(options), "predict"
        if not {"h0_m", "hv_m"} <= set(points):
            raise InputError("predict: give --h0 and --hv, or --points")
    predicted = fit.predict_at(points, place=place)
    write_points(predicted, options.output)
    print(fit.statement)
    if len(predicted) == 1 and not (options.points or options.output):
        valid = predicted["validity"].iloc[0]
        print(f"validity  {valid}")
        if valid not in (OK, FILM_UNKNOWN):
            raise RunError(f"outside the limits of validity: {valid}")


def read_points(path: Path | str) -> pd.DataFrame:
    """A table of points: h0_m, hv_m, and a position in polar or Cartesian form, if any.

    Raises InputError naming the file and the column that is missing or holds no numbers.
    """
    table = read_columns(path, columns=("h0_m", "hv_m"))
    for name in (*FACTORS.values(), *COLUMNS.values()):
        if name in table and not pd.api.types.is_numeric_dtype(table[name]):
            raise InputError(f"{path}: {name}: a value is not a number")
    return table
