"""Write the physics limit of each scene of a table: its force without solving in time or fitting.

  squeezefilm limits SCENES.csv --config C.yaml --output LIMITS.csv

`fast_limit_n` is the force at infinite squeeze number, `limit_n` the same with the boundary layer
at the finger's rim, correct to 1/√σ (with inertia also to ε²), `limit_error_n` the estimate of what
that leaves out, and `sigma` the squeeze number. Models may use these columns beside the factors.
Where the limit does not hold, the numbers are left out and `status` says so.
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.io.positions import as_in
from squeezefilm.io.tables import LIMIT_COLUMNS, read_scenes, write_table
from squeezefilm.studies.study import scenes_in
from squeezefilm.studies.tasks.physics_limits import with_limits


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", metavar="SCENES.csv", help="table of scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="LIMITS.csv", help="table to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    table = read_scenes(options.scenes)
    scenes = scenes_in(table, config)
    write_table(with_limits(table, scenes)[as_in(LIMIT_COLUMNS, table)], options.output)
