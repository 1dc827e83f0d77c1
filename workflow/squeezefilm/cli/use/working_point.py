"""The amplitude that gives a wanted force, by a fitted model, from its file alone.

  squeezefilm working-point FIT.json --force 1.0N --h0 5um:10um:6 --x 0mm,1mm

One row for each gap and position; without --h0, six gaps over the range that the model was fitted
on. `hv_error_m` is the model's error in force (see `squeezefilm predict --help`) over the slope of
force against amplitude, and `within_percent` is by how much the force there may be off, as
`predict` says it; both contain what the scan of a measured profile leaves open, `scan_percent`.
Where both are empty the point is not to be trusted, and `note` says why, or that no amplitude below
contact gives the force.
"""

from __future__ import annotations

import argparse

import numpy as np
import pandas as pd

from squeezefilm.cli.use.predict import (
    add_control_option,
    expected_error,
    read_judged_fit,
    scan_percent,
    within_percent,
)
from squeezefilm.io.errors import InputError
from squeezefilm.io.quantities import quantity
from squeezefilm.io.tables import write_table
from squeezefilm.models.fitted import FittedModel
from squeezefilm.models.force_model import Factors
from squeezefilm.models.points import add_point_options, factors_of_points, points_of, show_points

SECTIONS: tuple[str, ...] = ()
GAPS = 6
STEP = 1e-4
"""Relative step of the amplitude in the slope of the force."""


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
    error_n = expected_error(fit, options.validation)
    rows = [working_point(fit, point, force_n=force_n, error_n=error_n) for point in _each(points)]
    table = pd.concat([points, pd.DataFrame(rows)], axis=1)
    if options.output:
        write_table(table, options.output)
    else:
        show_points(table)


def working_point(
    fit: FittedModel, point: Factors, *, force_n: float, error_n: float
) -> dict[str, object]:
    """Amplitude, its error and a note for one gap and position; NaN where there is none."""
    model = fit.force_model
    point = fit.represented(point)
    where = {
        "h0_m": float(point.h0_m[0]),
        "phi_r_m": float(point.phi_r_m[0]),
        "phi_deg": float(point.phi_deg[0]),
    }
    unknown = dict.fromkeys(("hv_m", "hv_error_m", "within_percent"), np.nan)
    row: dict[str, object] = {"force_n": force_n, **unknown, **scan_percent(fit), "note": ""}
    if model.column_names:
        fit.complete(point)  # says what is missing, if anything
    try:
        hv_m = model.amplitude_for_force(
            fit.theta,
            force_n=force_n,
            complete=fit.complete if model.column_names else None,
            **where,
        )
    except InputError as error:
        return row | {"note": str(error).removeprefix("force_n: ")}
    near = Factors.of(**where | {"hv_m": hv_m * np.array([1 - STEP, 1.0, 1 + STEP])})
    below, _, above = model.evaluate(fit.theta, fit.complete(near))
    slope = (above - below) / (2 * STEP * hv_m) if hv_m else np.nan
    verdict = fit.judge(near.take([1]), [force_n])
    error_n = error_n + fit.scan_error * abs(force_n)
    error_m = error_n / abs(slope) if slope and verdict.trusted[0] else np.nan
    within = within_percent(verdict, np.array([force_n]))[0]
    known = {"hv_m": hv_m, "hv_error_m": error_m, "within_percent": within}
    return row | known | {"note": verdict.reasons[0]}


def _force(text: str) -> float:
    """The wanted force; a plain number is in newtons."""
    try:
        value = float(text)
    except ValueError:
        return quantity(text, option="--force", unit="N")
    if not np.isfinite(value):
        raise InputError(f"--force {text!r} must be a finite force, such as 1.0N")
    return value


def _each(points: pd.DataFrame) -> list[Factors]:
    factors = factors_of_points(points.assign(hv_m=0.0), place="working-point")
    return [factors.take([index]) for index in range(len(factors))]
