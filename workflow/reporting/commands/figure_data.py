"""Build the one table that a figure is drawn from.

Each figure needs tables of its own, given as NAME=PATH, for instance

    squeezefilm figure-data fig08 forces=screen/forces.csv fit=fits/screen.json \\
        --config config/paper.yaml --output fig08.csv

Leave the tables out to be told which ones a figure needs.
"""

from __future__ import annotations

import argparse

from reporting.figure_data import figure_data_module
from reporting.figures import FIGURES
from squeezefilm.io.sources import parse_sources
from squeezefilm.io.tables import write_table
from squeezefilm.studies.config import load_config

# Those of the figure alone, in its module.
SECTIONS: tuple[str, ...] = ()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("figure", metavar="FIGURE", help=", ".join(FIGURES))
    parser.add_argument(
        "inputs", metavar="NAME=PATH", nargs="*", help="the tables it is built from"
    )
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml")
    parser.add_argument("--output", required=True, metavar="FIGURE.csv")


def run(options: argparse.Namespace) -> None:
    module = figure_data_module(options.figure)
    inputs = parse_sources(options.inputs, names=module.INPUTS, user=options.figure)
    config = load_config(options.config).only(module.SECTIONS)
    write_table(module.build(inputs, config), options.output)
