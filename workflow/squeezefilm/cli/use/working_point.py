"""The amplitude that gives a wanted force, by a fitted model, from its file alone.

  squeezefilm working-point FIT.json --force 1.0N --h0 5um:10um:6 --x 0mm,1mm

One row for each gap and position; without --h0, six gaps over the range that the model was fitted
on. `hv_error_m` is the model's error in force (see `squeezefilm predict --help`) over the slope of
force against amplitude, and `within_percent` is by how much the force there may be off, as
`predict` says it; both contain what the scan of a measured profile leaves open, `scan_percent`.
Where both are empty the point is not to be trusted, and `note` says why, or that no amplitude below
contact gives the force.
"""

import argparse

import numpy as np
import pandas as pd

from squeezefilm.cli.points import (
    add_control_option,
    add_point_options,
    factors_of_points,
    points_of,
    write_points,
)
from squeezefilm.io.errors import InputError
from squeezefilm.io.typed_units import quantity
from squeezefilm.models.fitted import expected_error, read_judged_fit
from squeezefilm.models.working_point import working_point

GAPS = 6


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("--force", required=True, metavar="QUANTITY", help="wanted, e.g. 1.0N")
    parser.add_argument("--validation", metavar="ERRORS.json", help="the error to expect")
    parser.add_argument("--output", metavar="TABLE.csv", help="table to write, else it is shown")
    add_control_option(parser)
    add_point_options(parser, without=("hv_m",))


def run(options: argparse.Namespace) -> None:
    fit = read_judged_fit(options.fit, control=options.control)
    force_n = _force(options.force)
    if options.h0_m is None:
        if "h0_m" not in fit.ranges:
            raise InputError(f"{options.fit}: tells no range of gaps; give --h0")
        low, high = fit.ranges["h0_m"]
        options.h0_m = f"{low!r}m:{high!r}m:{GAPS}" if high > low else f"{low!r}m"
    points = points_of(options)
    factors = factors_of_points(points.assign(hv_m=0.0), place="working-point")
    error_n = expected_error(fit, options.validation)
    rows = [
        working_point(fit, factors.take([index]), force_n=force_n, error_n=error_n)
        for index in range(len(factors))
    ]
    write_points(pd.concat([points, pd.DataFrame(rows)], axis=1), options.output)


def _force(text: str) -> float:
    """The wanted force; a plain number is in newtons."""
    try:
        value = float(text)
    except ValueError:
        return quantity(text, option="--force", unit="N")
    if not np.isfinite(value):
        raise InputError(f"--force {text!r} must be a finite force, such as 1.0N")
    return value
