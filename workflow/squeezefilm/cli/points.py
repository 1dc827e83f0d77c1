"""The points at which a fitted model is asked, as options of a command or as a table."""

import argparse
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import pandas as pd

from squeezefilm.io.errors import InputError, naming
from squeezefilm.io.positions import CARTESIAN, POLAR
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import write_table
from squeezefilm.io.typed_units import quantities
from squeezefilm.models.force_model import COLUMNS, Factors

OPTIONS = {
    "h0_m": ("--h0", "m", "mean gap, e.g. 5um; several 5um,6um; or 5um:10um:6"),
    "hv_m": ("--hv", "m", "amplitude at the profile's maximum, likewise"),
    "x_m": ("--x", "m", "finger's centre, e.g. 1mm, likewise; 0 m if left out"),
    "y_m": ("--y", "m", "the same along y"),
    "phi_r_m": ("--phi-r", "m", "instead of --x and --y: distance from the centre, e.g. 2.9mm"),
    "phi_deg": ("--phi", "deg", "and direction, e.g. 45deg"),
}
MOST_POINTS = 1_000_000


def add_point_options(parser: argparse.ArgumentParser, *, without: Sequence[str] = ()) -> None:
    """Options for the factors, but for those in ``without``."""
    group = parser.add_argument_group("points: every combination of")
    for name, (option, _, text) in OPTIONS.items():
        if name not in without:
            group.add_argument(option, dest=name, metavar="QUANTITY", help=text)


def add_control_option(parser: argparse.ArgumentParser) -> None:
    """The option of the simulations that a fit is judged by."""
    parser.add_argument(
        "--control", nargs="+", metavar="FORCES.csv", help="simulations to judge the fit by"
    )


def points_of(options: argparse.Namespace) -> pd.DataFrame:
    """Every combination of the options' values, a column for each factor given.

    Raises InputError for a value without its unit, both forms of a position, or too many points.
    """
    given = {name: getattr(options, name, None) for name in OPTIONS}
    levels = {
        name: quantities(text, option=OPTIONS[name][0], unit=OPTIONS[name][1])
        for name, text in given.items()
        if text is not None
    }
    if any(name in levels for name in CARTESIAN) and any(name in levels for name in POLAR):
        raise InputError("give the position as --x and --y or as --phi-r and --phi, not both")
    count = 1
    for values in levels.values():
        count *= len(values)
    if count > MOST_POINTS:
        raise InputError(f"the options make {count} points; at most {MOST_POINTS} are allowed")
    return pd.DataFrame(list(product(*levels.values())), columns=list(levels))


def read_points(path: Path | str) -> pd.DataFrame:
    """A table of points: h0_m, hv_m, and a position in polar or Cartesian form, if any.

    Raises InputError naming the file and the column that is missing or holds no numbers.
    """
    table = read_columns(path, columns=("h0_m", "hv_m"))
    for name in (*OPTIONS, *COLUMNS.values()):
        if name in table and not pd.api.types.is_numeric_dtype(table[name]):
            raise InputError(f"{path}: {name}: a value is not a number")
    return table


def write_points(points: pd.DataFrame, path: str | None) -> None:
    """Write a table of points, or print it for people where no path is given."""
    if path:
        write_table(points, path)
    else:
        print(points.to_string(index=False, float_format=lambda value: f"{value:.6g}"))


def factors_of_points(points: pd.DataFrame, *, place: object) -> Factors:
    """The factors of a table of points, with the results of physics that it has.

    Raises InputError naming the place, for values without physical meaning.
    """
    names = [name for name in (*OPTIONS, *COLUMNS.values()) if name in points]
    if any(name in names for name in POLAR):  # a table may have both; one says it all
        names = [name for name in names if name not in CARTESIAN]
    with naming(place):
        return Factors.of(**{name: points[name].to_numpy(dtype=float) for name in names})
