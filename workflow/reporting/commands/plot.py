"""Draw a figure from its table, and from nothing else.

    squeezefilm plot fig08 fig08.csv --output fig08.png fig08.svg

The format follows the name: .png, .svg or .pdf. The same table gives the same file, byte for byte.
"""

import argparse

from reporting.figures import HELP, check_formats, draw, figure_module


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("figure", metavar="FIGURE", help=HELP)
    parser.add_argument("data", metavar="FIGURE.csv", help="the figure's table")
    parser.add_argument("--output", required=True, nargs="+", metavar="FILE")


def run(options: argparse.Namespace) -> None:
    check_formats(options.output)
    draw(figure_module(options.figure), options.data, options.output)
