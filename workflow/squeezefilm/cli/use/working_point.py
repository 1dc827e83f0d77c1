"""The amplitude that gives a wanted force, by a fitted model, from its file alone.

  squeezefilm working-point FIT.json --force 1.0N --h0 5um:10um:6 --x 0mm,1mm

One row for each gap and position; without --h0, six gaps over the range that the model was fitted
on. `hv_error_95_m` is the 95 % error of the force (see `squeezefilm predict --help`) over the slope
of force against amplitude, and `error_95_percent` that of the force; both contain the uncertainty
of a measured profile, `profile_uncertainty_percent`. Where the point is not validated both are
empty and `note` says why, or that no amplitude below contact gives the force.
"""

import argparse

from squeezefilm.api.fit import Fit, newtons
from squeezefilm.cli.options import add_point_options, points_in, write_points


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("--force", required=True, metavar="QUANTITY", help="wanted, e.g. 1.0N")
    parser.add_argument("--output", metavar="TABLE.csv", help="table to write, else it is shown")
    add_point_options(parser, without=("hv",))


def run(options: argparse.Namespace) -> None:
    fit = Fit.read(options.fit)
    force_n = newtons(options.force, option="--force")
    points = points_in(options, **({} if options.h0 else {"h0": fit.gaps()}))
    write_points(fit.working_points_at(points, force_n=force_n), options.output)
    print(fit.statement)
