"""The points that people ask for as options of a command, and what is answered."""

import argparse
from collections.abc import Sequence

import pandas as pd

from squeezefilm.api.points import Values, points_of
from squeezefilm.tables import write_table
from squeezefilm.units import to_its_error

OPTIONS = {
    "h0": "mean gap, e.g. 5um",
    "hv": "amplitude at the profile's maximum, e.g. 2um",
    "x": "finger's centre, e.g. -2mm; 0 m if left out",
    "y": "the same along y",
    "phi_r": "instead of --x and --y: distance from the centre, e.g. 2.9mm",
    "phi": "and direction, e.g. 45deg",
}
ERRORS = {"force_n": "error_95_n", "hv_m": "hv_error_95_m"}
"""Columns that are shown to the digits that another column leaves them."""


MANY = "each one value, several (5um,6um), or a range first:last:count (5:10:6um)"


def add_point_options(
    parser: argparse.ArgumentParser, *, without: Sequence[str] = (), many: bool = True
) -> None:
    """Options for the factors, but for those in ``without``; ``many`` values of each."""
    title = "points: every combination of" if many else "the point"
    group = parser.add_argument_group(title, MANY if many else None)
    for name, text in OPTIONS.items():
        if name not in without:
            group.add_argument(f"--{name.replace('_', '-')}", metavar="QUANTITY", help=text)


def points_in(options: argparse.Namespace, **defaults: Values) -> pd.DataFrame:
    """Every combination of the options' values, a column for each factor given or with a default.

    Raises InputError for a value without its unit, both forms of a position, or too many points.
    """
    given = {name: getattr(options, name, None) for name in OPTIONS}
    values = {name: defaults.get(name) if each is None else each for name, each in given.items()}
    return points_of(values, option="--{}")


def write_points(points: pd.DataFrame, path: str | None) -> None:
    """Write a table of points, or print it for people where no path is given.

    What is printed has no more digits than its error leaves.
    """
    if path:
        write_table(points, path)
        return
    shown = points.copy()
    for name, error in ERRORS.items():
        if name in points and error in points:
            pairs = [to_its_error(*each) for each in zip(points[name], points[error], strict=True)]
            shown[name], shown[error] = zip(*pairs, strict=True)
    print(shown.to_string(index=False, float_format=lambda value: f"{value:.4g}"))
