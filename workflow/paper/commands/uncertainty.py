"""How far each assumption would have to move to explain the differences from the paper.

  squeezefilm uncertainty --config CONFIG.yaml --output TABLE.csv --markdown TABLE.md \\
      --curves CURVES.csv

Viscosity, ambient pressure, the finger's side, the profile's wave number, slip and others are
changed one at a time and the forces simulated anew. The curves say how the force goes with each.
"""

from __future__ import annotations

import argparse

from paper.uncertainty import compare, to_markdown
from squeezefilm.film.scene import Scene
from squeezefilm.io.markdown import write_markdown
from squeezefilm.io.tables import write_table
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.studies.config import load_config

SECTIONS = ("gas", "actuator", "finger", "solver", "screen", "extrapolation")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")
    parser.add_argument("--markdown", required=True, metavar="TABLE.md", help="and for people")
    parser.add_argument("--curves", required=True, metavar="CURVES.csv", help="force over change")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config).only(SECTIONS)
    settings = config["solver"]
    device = choose_device(settings["device"])

    def force(scene: Scene) -> float:
        [solution] = solve([scene], tolerance=settings["tolerance"], device=device)
        return solution.force_n

    table, curves = compare(config, force=force)
    write_table(table, options.output)
    write_markdown(to_markdown(table), options.markdown)
    write_table(curves, options.curves)
