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

from squeezefilm.api.fit import Fit, newtons
from squeezefilm.cli.points import (
    add_control_option,
    add_point_options,
    points_in,
    write_points,
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("--force", required=True, metavar="QUANTITY", help="wanted, e.g. 1.0N")
    parser.add_argument("--validation", metavar="ERRORS.json", help="the error to expect")
    parser.add_argument("--output", metavar="TABLE.csv", help="table to write, else it is shown")
    add_control_option(parser)
    add_point_options(parser, without=("hv",))


def run(options: argparse.Namespace) -> None:
    fit = Fit.read(options.fit, control=options.control, validation=options.validation)
    force_n = newtons(options.force, option="--force")
    points = points_in(options, **({} if options.h0 else {"h0": fit.gaps()}))
    write_points(fit.working_points_at(points, force_n=force_n), options.output)
