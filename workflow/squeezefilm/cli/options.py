"""Options that several commands have, and what they stand for."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from squeezefilm.api.film import Film
from squeezefilm.api.points import Values, points_of
from squeezefilm.config.loading import load_film
from squeezefilm.errors import InputError
from squeezefilm.reynolds.solver import METHODS
from squeezefilm.tables import write_table
from squeezefilm.units import to_its_error

PAPER_CONFIG = Path(__file__).parents[3] / "config" / "paper.yaml"
"""Where the library lies in a checkout; an installed one has no study of its own."""
SHARED: dict[str, dict[str, Any]] = {
    "config": {"metavar": "CONFIG.yaml", "help": "the study; a checkout's paper.yaml if left out"},
    "device": {"help": "instead of SQUEEZEFILM_DEVICE and the config's solver.device"},
    "tolerance": {"type": float, "help": "instead of the config's solver.tolerance"},
    "method": {"choices": METHODS, "help": "instead of the config's solver.method"},
}
POINTS = {
    "h0": "mean gap, e.g. 5um",
    "hv": "amplitude at the profile's maximum, e.g. 2um",
    "x": "finger's centre, e.g. -2mm; 0 m if left out",
    "y": "the same along y",
    "phi_r": "instead of --x and --y: distance from the centre, e.g. 2.9mm",
    "phi": "and direction, e.g. 45deg",
}
MANY = "each one value, several (5um,6um), or a range first:last:count (5:10:6um)"
ERRORS = {"force_n": "error_95_n", "hv_m": "hv_error_95_m"}
"""Columns that are shown to the digits that another column leaves them."""


def add_options(parser: argparse.ArgumentParser, *names: str) -> None:
    """Some of the options in SHARED."""
    for name in names:
        parser.add_argument(f"--{name}", **SHARED[name])


def film_at(path: str | None) -> Film:
    """The film of a study, of which no section is checked that film and solver do not need.

    Raises InputError where none is named and there is none, and as ``load_film`` does.
    """
    if path is None and not PAPER_CONFIG.exists():
        raise InputError("give a study by --config CONFIG.yaml")
    return Film(load_film(path or PAPER_CONFIG))


def add_point_options(
    parser: argparse.ArgumentParser, *, without: Sequence[str] = (), many: bool = True
) -> None:
    """Options for the factors, but for those in ``without``; ``many`` values of each."""
    title = "points: every combination of" if many else "the point"
    group = parser.add_argument_group(title, MANY if many else None)
    for name, text in POINTS.items():
        if name not in without:
            group.add_argument(f"--{name.replace('_', '-')}", metavar="QUANTITY", help=text)


def points_in(options: argparse.Namespace, **defaults: Values) -> pd.DataFrame:
    """Every combination of the options' values, a column for each factor given or with a default.

    Raises InputError for a value without its unit, both forms of a position, or too many points.
    """
    given = {name: getattr(options, name, None) for name in POINTS}
    return points_of(
        option="--{}",
        **{name: defaults.get(name) if each is None else each for name, each in given.items()},
    )


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
