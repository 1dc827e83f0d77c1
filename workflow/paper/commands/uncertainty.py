"""How far each assumption would have to move to explain the differences from the paper.

  squeezefilm uncertainty --config CONFIG.yaml --output TABLE.csv --markdown TABLE.md \\
      --curves CURVES.csv

Viscosity, ambient pressure, the finger's side, the profile's wave number, slip and others are
changed one at a time and the forces simulated anew. The curves say how the force goes with each.
"""

import argparse

from paper.uncertainty import compare, to_markdown
from squeezefilm.film.scene import Scene
from squeezefilm.io.atomic import write_text
from squeezefilm.io.tables import write_table
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.reynolds import solve
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")
    parser.add_argument("--markdown", required=True, metavar="TABLE.md", help="and for people")
    parser.add_argument("--curves", required=True, metavar="CURVES.csv", help="force over change")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    tolerance, device = config["solver"]["tolerance"], device_of(config)

    def force(scene: Scene) -> float:
        scenes = resolve_auto_terms([scene], device=device)
        [solution] = solve(scenes, tolerance=tolerance, device=device)
        return solution.force_n

    table, curves = compare(config, force=force)
    write_table(table, options.output)
    write_text(to_markdown(table), options.markdown)
    write_table(curves, options.curves)
