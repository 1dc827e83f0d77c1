"""Run time and memory against scenes, points, instants, cores and scenes a call.

  squeezefilm cost --config CONFIG.yaml --output TABLE.csv

Every size runs in a process of its own, warm, median of repeats: processor time of all threads,
wall time, and the process's largest memory.
"""

import argparse

from numerics.cost import cost, sizes
from squeezefilm.io.tables import write_table
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    settings, device = config["numerics"], device_of(config)
    table = cost(
        sizes(full=settings["extent"] == "full"),
        repeats=settings["repeats"],
        device=config["solver"]["device"],
        device_name=device.name,
    )
    note = (
        f"Warm, median of {settings['repeats']}; {device.name}. Scenes: random points of the "
        "paper's space, at a tolerance of 1e-3; cores and scenes a call: at 1e-6."
    )
    write_table(table.assign(note=note), options.output)
