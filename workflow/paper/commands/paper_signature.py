"""Which numerical shortcuts would give the errors that the paper reports.

  squeezefilm paper-signature SCREEN.csv DESIGN.csv EXTRAPOLATION.csv --config CONFIG.yaml \\
      --output TABLE.csv --points POINTS.csv

The inputs are the converged forces of the screen, of the five-point design and of the
extrapolated operating point. The screen is simulated anew with coarse meshes, loose tolerances
and few periods, and the paper's fits are repeated on what comes out.
"""

import argparse
from pathlib import Path

import numpy as np

from paper.paper_signature import Chain, families, paper_signature
from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import SCENE_COLUMNS, read_ok_forces, scene_points, write_table
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.study import scene_of

NOTE = (
    "The two-factor model fitted to forces as simulated in each way, and judged on them. Thin "
    "lines: the paper's values; dotted: the converged force. Left and middle: finite elements "
    "marched from ambient pressure at the mean gap (solid) or the widest gap (dashed), the mean "
    "force of the last period taken. Right: loose integrators over 20 periods, coarse even meshes "
    "over 40, long steps over 40."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("screen", metavar="SCREEN.csv", help="converged forces of the screen")
    parser.add_argument("design", metavar="DESIGN.csv", help="and of the design")
    parser.add_argument("extrapolation", metavar="EXTRAPOLATION.csv", help="and beyond the screen")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="a row per shortcut")
    parser.add_argument("--points", required=True, metavar="POINTS.csv", help="and per point")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    if not config["gas"]["inertia"] == config["gas"]["heat"] == "none":
        raise InputError(f"{options.config}: the shortcuts are of films without inertia and heat")
    full = config["numerics"]["extent"] == "full"
    screen, screen_force = _forces(options.screen, config)
    design, design_force = _forces(options.design, config)
    beyond, beyond_force = _forces(options.extrapolation, config)
    named = [scene.point_id for scene in beyond]
    if "operating_point" not in named:
        raise InputError(f"{options.extrapolation}: there is no point 'operating_point'")
    index = named.index("operating_point")
    table, points = paper_signature(
        families(full=full),
        Chain(
            screen=screen,
            design=design,
            extrapolated=beyond[index],
            screen_force_n=screen_force,
            design_force_n=design_force,
            extrapolated_force_n=float(beyond_force[index]),
        ),
    )
    write_table(table.assign(note=NOTE), options.output)
    write_table(points, options.points)


def _forces(path: Path | str, config: Config) -> tuple[list[Scene], np.ndarray]:
    """The scenes of a table of forces, and the forces in newtons."""
    table = read_ok_forces(path)
    scenes = [scene_of(point, config) for point in scene_points(table[list(SCENE_COLUMNS)])]
    return scenes, table["force_n"].to_numpy(dtype=float)
