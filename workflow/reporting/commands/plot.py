"""Draw a figure of a finished study, or its table.

    squeezefilm plot fig08 results/paper --output fig08.pdf

The format follows the name: .png, .svg or .pdf; .csv is the table that a numbered figure of the
paper draws. The same results give the same file, byte for byte.
"""

import argparse
from importlib.metadata import entry_points
from pathlib import Path

from reporting.results import Results
from squeezefilm.errors import InputError

FORMATS = (".png", ".svg", ".pdf", ".csv")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "figure", metavar="FIGURE", help="fig05, overview, models/two_factor_errors"
    )
    parser.add_argument("results", type=Path, metavar="RESULTS", help="the study's results")
    parser.add_argument("--config", metavar="CONFIG.yaml", help="the study, if not RESULTS' own")
    parser.add_argument("--output", required=True, nargs="+", type=Path, metavar="FILE")


def run(options: argparse.Namespace) -> None:
    for path in options.output:
        if path.suffix not in FORMATS:
            raise InputError(f"{path}: a figure's name ends in {', '.join(FORMATS)}")
    from reporting.figures import FIGURES, save  # matplotlib: only when something is drawn

    figures = dict(FIGURES)
    for point in entry_points(group="squeezefilm.figures"):
        figures |= point.load()
    place = options.figure if "/" in options.figure else f"figures/{options.figure}"
    if place not in figures:
        known = ", ".join(name.removeprefix("figures/") for name in figures)
        raise InputError(f"there is no figure {options.figure!r}; the figures are {known}")
    save(figures[place], Results.of(options.results, options.config), options.output)
