"""Commands that use a fitted model, from its file alone."""

import argparse
from pathlib import Path

from squeezefilm.api.models import Fit
from squeezefilm.cli.options import (
    FIT_ARGUMENT,
    RESULT_OPTIONS,
    command,
    factor_options,
    option,
    points_of_options,
    write_or_print_rows,
)
from squeezefilm.errors import InputError, RunError
from squeezefilm.files import write_text
from squeezefilm.film.positions import fill_missing_coordinate
from squeezefilm.film.validity import OK
from squeezefilm.formatting import column_label
from squeezefilm.lazy import pd
from squeezefilm.models.export import NAN_OF_LANGUAGE
from squeezefilm.models.fit_file import UNKNOWN_PREFIX
from squeezefilm.tables import read_scenes
from squeezefilm.units import split_unit


@command(
    FIT_ARGUMENT,
    option("--points", "POINTS.csv", "points as a table"),
    *RESULT_OPTIONS,
    factor_options(),
)
def predict(options: argparse.Namespace) -> None:
    """Forces by a fitted model, from its file alone.

      squeezefilm predict FIT.json --h0 5um --hv 0.5:2:4um --x 1mm
      squeezefilm predict FIT.json --points POINTS.csv --output FORCES.csv

    A quantity is a number with its unit, several with commas, or evenly spaced ones as
    first:last:count; every combination is a point. POINTS.csv is a table of scenes (see
    `squeezefilm simulate --help`); by the symmetry of the study that the model was fitted in, any
    direction may be asked. `error_95_n` is the error that 95 % of new points drawn uniformly from
    the study's declared space do not exceed, `error_99_n` the same for 99 %, measured on a
    validation sample of simulations that no fit used.

    Outside the declared space, and for a fit without such a sample, both are empty and `note` says
    so. Where the profile was measured, both contain the uncertainty of its scan,
    `profile_uncertainty_percent` of the force; the validation sample measures the rest,
    `error_95_without_scan_percent`. `validity` is `ok`, or the limits of validity of the
    film equation that a point exceeds, or why there is no film: surface and pad touch, or the pad
    lies off the surface. The exit status is 1 when a point has no force, and where one point by
    options is outside the limits; all rows are written nevertheless.
    """
    fit = Fit.read(options.fit)
    if options.points:
        table, source = read_scenes(options.points), options.points
    else:
        table, source = _points_of_options(options), "predict"
        if not {"h0_m", "hv_m"} <= set(table):
            raise InputError("predict: give --h0 and --hv, or --points")
    predicted = fit.predict_at(table, source=source)
    _show_results(predicted, "force_n", options, source=source, **fit.about)


@command(
    FIT_ARGUMENT,
    option("--force", "QUANTITY", "target, e.g. 1.0N", required=True),
    *RESULT_OPTIONS,
    factor_options("hv"),
)
def amplitude_for(options: argparse.Namespace) -> None:
    """The amplitude for a target force, by a fitted model, from its file alone.

      squeezefilm amplitude-for FIT.json --force 1.0N --h0 5:10:6um --x 0mm,1mm

    One row for each gap and position; without --h0, six gaps over the range that the model was
    fitted on. `hv_error_95_m` is the 95 % error of the force (see `squeezefilm predict --help`)
    over the slope of force against amplitude, and `error_95_percent` that of the force; both
    contain the uncertainty of a measured profile, `profile_uncertainty_percent`. Where the point is
    not validated both are empty and `note` says why, or which forces the model gives. The exit
    status is 1 when a point has no amplitude, and where one point by options is outside the limits
    of validity.
    """
    fit = Fit.read(options.fit)
    options.h0 = options.h0 or fit.gaps()
    points = _points_of_options(options)
    amplitudes = fit.amplitudes_for(points, options.force)
    _show_results(amplitudes, "hv_m", options, source="amplitude-for", **fit.about)


def _show_results(
    table: pd.DataFrame,
    name: str,
    options: argparse.Namespace,
    *,
    source: Path | str,
    **about: str,
) -> None:
    """Write or print results of a fit; of one point without a result, the reason alone.

    Args:
        name: the result's column.
        about: as ``write_or_print_rows`` takes them.

    Raises RunError for rows without a result, and for one point by options that is outside the
    limits of validity.
    """
    result, missing = column_label(split_unit(name)[0]), int(table[name].isna().sum())
    by_options = not getattr(options, "points", None)
    alone = len(table) == 1 and by_options and not options.output
    if alone and missing and not options.json:
        note = str(table["note"].iloc[0]).removeprefix("not validated: ")
        raise RunError(f"no {result}: {note or table['validity'].iloc[0]}")
    write_or_print_rows(table, options, **about)
    if missing:
        rows = f"{missing} of {len(table)} rows"
        raise RunError(f"{source}: no {result} for {rows}; `validity` or `note` states the reason")
    valid = table["validity"].iloc[0]
    if alone and valid != OK and not valid.startswith(UNKNOWN_PREFIX):
        raise RunError(f"outside the limits of validity: {valid}")


def _points_of_options(options: argparse.Namespace) -> pd.DataFrame:
    """The points as a table; a single one that is printed with the position that is taken."""
    points = pd.DataFrame(points_of_options(options))
    alone = len(points) == 1 and not options.output
    return fill_missing_coordinate(points) if alone else points


@command(
    FIT_ARGUMENT,
    option("--language", help="of the code", required=True, choices=NAN_OF_LANGUAGE),
    option("--output", "FILE", "file to write, else it is shown"),
)
def export(options: argparse.Namespace) -> None:
    """Write a fitted model as code without dependencies, for firmware and for notebooks.

      squeezefilm export FIT.json --language c --output force.h
      squeezefilm export FIT.json --language python --output force.py
      squeezefilm export FIT.json --language javascript --output force.js
      squeezefilm export FIT.json --language matlab --output force.m

    The C header (C99, <math.h>) has NAME_force_n(h0_m, hv_m, …), the Python module force_n(h0_m,
    hv_m, …), JavaScript a constant NAME with NAME.force_n(h0_m, hv_m, …), MATLAB a function of the
    file's name: all in newtons from SI units (phi_deg in degrees), with a function for the 95 %
    error of a force and one that says whether a point lies in the declared space (see
    `squeezefilm predict --help`).

    A model that uses the asymptotic expansion is written with its table of it, whose error is
    stated; without a table, where the expansion does not hold all over the study's space, it cannot
    be exported.
    """
    own_file = options.output and options.language == "matlab"
    name = Path(options.output).stem if own_file else ""
    text = Fit.read(options.fit).code(options.language, name=name)
    if options.output:
        write_text(text, options.output)
    else:
        print(text, end="")
