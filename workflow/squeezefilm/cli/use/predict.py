"""Forces by a fitted model, from its file alone.

  squeezefilm predict FIT.json --h0 5um --hv 0.5um:2um:4 --x 1mm
  squeezefilm predict FIT.json --points POINTS.csv --output FORCES.csv

A quantity is a number with its unit, several with commas, or evenly spaced ones as
first:last:count; every combination is a point. POINTS.csv has the columns h0_m, hv_m and, for a
finger off the centre, x_m, y_m or phi_r_m, phi_deg; by the symmetry of the study that the model
was fitted in, any direction may be asked. `force_error_n` is what the model erred by at
points that were left out of its fit (root mean square); --validation gives the summary of
`squeezefilm validate` to take instead. `within_percent` is by how much the force may be off at that
point, judged by simulations that the fit never saw: points left out in turn, or those that
--control gives. Where both are empty the force is not to be trusted, and `note` says why.
Where the profile was measured, both contain what its scan leaves open, `scan_percent` of the force.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence

import numpy as np
import pandas as pd

from squeezefilm.designs.experiments import factors_of
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import read_json, read_ok_forces, write_table
from squeezefilm.models.fitted import FittedModel, number, read_fit
from squeezefilm.models.points import (
    add_point_options,
    factors_of_points,
    points_of,
    read_points,
    show_points,
)
from squeezefilm.models.trust import Verdict

SECTIONS: tuple[str, ...] = ()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("--points", metavar="POINTS.csv", help="points as a table")
    parser.add_argument("--validation", metavar="ERRORS.json", help="the error to expect")
    parser.add_argument("--output", metavar="FORCES.csv", help="table to write, else it is shown")
    add_control_option(parser)
    add_point_options(parser)


def run(options: argparse.Namespace) -> None:
    fit = read_judged_fit(options.fit, control=options.control)
    if options.points:
        points, place = read_points(options.points), options.points
    else:
        points, place = points_of(options), "predict"
        if not {"h0_m", "hv_m"} <= set(points):
            raise InputError("predict: give --h0 and --hv, or --points")
    factors = fit.represented(factors_of_points(points, place=place))
    force_n = fit.force_model.evaluate(fit.theta, fit.complete(factors))
    verdict = fit.judge(factors, force_n)
    table = points.assign(
        force_n=force_n,
        force_error_n=np.where(
            verdict.trusted,
            expected_error(fit, options.validation) + fit.scan_error * np.abs(force_n),
            np.nan,
        ),
        within_percent=within_percent(verdict, force_n),
        **scan_percent(fit),
        note=verdict.reasons,
    )
    if options.output:
        write_table(table, options.output)
    else:
        show_points(table)


def add_control_option(parser: argparse.ArgumentParser) -> None:
    """The option of the simulations that a fit is judged by."""
    parser.add_argument(
        "--control", nargs="+", metavar="FORCES.csv", help="simulations to judge the fit by"
    )


def read_judged_fit(path: str, *, control: Sequence[str] | None) -> FittedModel:
    """Read a fit, judged by the simulations of the tables in ``control`` that it never saw.

    Raises:
        InputError: naming the file, for one that cannot be read or a point that has no force.
    """
    fit = read_fit(path)
    if not control:
        return fit
    forces = pd.concat([read_ok_forces(each) for each in control], ignore_index=True)
    return fit.judged_by(
        factors_of(forces), force_n=forces["force_n"], force_error_n=forces["force_error_n"]
    )


def within_percent(verdict: Verdict, force_n: np.ndarray) -> np.ndarray:
    """The bound of the error in per cent of the force, shape (n,); NaN where it is not trusted."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = 100 * verdict.error_n / np.abs(force_n)
    return np.where(verdict.trusted, share, np.nan)


def scan_percent(fit: FittedModel) -> dict[str, float]:
    """A column for what the scan of a measured profile leaves open, in per cent of the force."""
    return {"scan_percent": 100 * fit.scan_error} if fit.scan_error else {}


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
