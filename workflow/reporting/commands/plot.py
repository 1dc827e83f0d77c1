"""Draw a figure from its table, and from nothing else.

    squeezefilm plot fig08 fig08.csv --output fig08.png fig08.svg

The format follows the name: .png, .svg or .pdf. The same table gives the same file, byte for byte.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from reporting.figures import FIGURES, figure_module
from squeezefilm.io.errors import InputError
from squeezefilm.io.sources import read_columns

SECTIONS: tuple[str, ...] = ()
FORMATS = (".png", ".svg", ".pdf")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("figure", metavar="FIGURE", help=", ".join(FIGURES))
    parser.add_argument("data", metavar="FIGURE.csv", help="the figure's table")
    parser.add_argument("--output", required=True, nargs="+", metavar="FILE")


def run(options: argparse.Namespace) -> None:
    from reporting.figures import style  # matplotlib: only when something is drawn

    for path in options.output:
        if Path(path).suffix not in FORMATS:
            raise InputError(f"{path}: a figure's name ends in {', '.join(FORMATS)}")
    module = figure_module(options.figure)
    data = read_columns(options.data, columns=module.COLUMNS)
    with style.settings():
        style.save(module.draw(data), options.output)
