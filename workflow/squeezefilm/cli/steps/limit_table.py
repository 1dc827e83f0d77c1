"""Tabulate the physics limits over a study's space, for the files of models that use them.

  squeezefilm limit-table --config C.yaml --output TABLE.json

`squeezefilm fit … --limit-table TABLE.json` puts the table into the fit's file. It holds gaps and
positions of the study's space and amplitudes up to 0.7 of the gap, as polynomials; their largest
error is stated, from random points of the space.
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import write_json
from squeezefilm.studies.tasks.physics_limits import limit_table_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.json", help="file to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    try:
        values = limit_table_of(config).model_dump(mode="json")
    except InputError as error:
        values = {"refused": str(error)}
        print(error)
    write_json(values, options.output)
