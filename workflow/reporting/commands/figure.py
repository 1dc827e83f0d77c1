"""Build the one table of a figure from a study's results, and draw the figure from it.

Each figure is made from files of its own, given as NAME=PATH, for instance

    squeezefilm figure fig08 forces=screen/forces.csv fit=fits/screen.json \\
        device=simulations/device.json --config config/paper.yaml --output fig08.csv fig08.png

Leave them out to be told which ones a figure needs. `squeezefilm plot` draws it again from the
table alone. NAME.plain.png is small and without texts, for `squeezefilm check`. A figure of a study
whose films go beyond Re 10 says so in its note.
"""

import argparse
from pathlib import Path

from reporting.figures import HELP, check_formats, draw, figure_module
from reporting.pages.notes import Inertia
from squeezefilm.config.loading import load_config
from squeezefilm.io.errors import InputError
from squeezefilm.io.sources import parse_sources
from squeezefilm.io.tables import write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("figure", metavar="FIGURE", help=HELP)
    parser.add_argument("inputs", metavar="NAME=PATH", nargs="*", help="the files it is made from")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml")
    parser.add_argument(
        "--output", required=True, nargs="+", metavar="FILE", help="the table (.csv) and drawings"
    )


def run(options: argparse.Namespace) -> None:
    module = figure_module(options.figure)
    inputs = parse_sources(options.inputs, names=tuple(module.INPUTS), user=options.figure)
    tables = [path for path in options.output if Path(path).suffix == ".csv"]
    drawings = [path for path in options.output if path not in tables]
    check_formats(drawings)
    study = load_config(options.config)
    beyond = Inertia.of(study).note(study["screen"]["h0_m"]["stop"])
    if hasattr(module, "build"):
        if len(tables) != 1:
            raise InputError(f"{options.figure}: name one table to write, FIGURE.csv")
        table = module.build(inputs, study)
        write_table(
            table.assign(note=[f"{each} {beyond}".strip() for each in table["note"]]), tables[0]
        )
        beyond = ""
    elif tables:
        raise InputError(
            f"{options.figure}: it is drawn from its input as it stands: no {tables[0]}"
        )
    else:
        tables = list(inputs.values())
    if drawings:
        draw(module, tables[0], drawings, beyond=beyond)
