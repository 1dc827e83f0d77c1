"""What each scene needs: method, domain, terms, points, what is left out and why.

  squeezefilm explain SCENES.csv --config CONFIG.yaml
  squeezefilm explain SCENES.csv --config CONFIG.yaml --output EXPLAINED.csv

Nothing is solved. The expected error is relative, the expected cost in millions of floating-point
operations; notes say where the Reynolds equation itself is stretched.
"""

import argparse

import pandas as pd

from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import naming
from squeezefilm.io.tables import read_scenes, scene_points, write_table
from squeezefilm.reynolds.explain import Explanation, explain
from squeezefilm.reynolds.regime import regime_notes
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import add_solver_arguments, solver_settings
from squeezefilm.studies.study import scene_of

SECTIONS = ("gas", "actuator", "finger", "solver")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", metavar="SCENES.csv", help="table of scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", metavar="EXPLAINED.csv", help="table to write, with every row")
    add_solver_arguments(parser)


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config).only(SECTIONS)
    settings = solver_settings(options, config)
    points = scene_points(read_scenes(options.scenes))
    with naming(options.scenes):
        scenes = [scene_of(point, config) for point in points]
    explanations = explain(scenes, **settings)
    table = pd.DataFrame(
        [_row(scene, each) for scene, each in zip(scenes, explanations, strict=True)]
    )
    if options.output is not None:
        write_table(table, options.output)
    print(_summary(table, tolerance=settings["tolerance"]))


def _row(scene: Scene, explanation: Explanation) -> dict[str, object]:
    return {
        "point_id": scene.point_id,
        "epsilon": scene.epsilon,
        "sigma": scene.sigma,
        "bearing_number": scene.bearing_number,
        "knudsen": scene.knudsen,
        "modified_reynolds": scene.modified_reynolds,
        "method": explanation.method,
        "status": explanation.status,
        "domain": explanation.domain,
        "terms": "; ".join(explanation.terms),
        "nx": explanation.nx,
        "ny": explanation.ny,
        "nt": explanation.nt,
        "left_out": "; ".join(part.what for part in explanation.left_out),
        "why": "; ".join(f"{part.what}: {part.why}" for part in explanation.left_out),
        "expected_error": explanation.expected_error,
        "expected_mflop": explanation.expected_mflop,
        "notes": "; ".join(regime_notes(scene)),
    }


def _summary(table: pd.DataFrame, *, tolerance: float) -> str:
    """The rows that are treated alike, put together."""
    kinds = table.assign(points=1).groupby(
        ["method", "domain", "terms", "left_out"], sort=False, as_index=False
    )
    summary = kinds.agg(
        scenes=("points", "sum"),
        nx=("nx", "max"),
        ny=("ny", "max"),
        nt=("nt", "max"),
        expected_error=("expected_error", "max"),
        expected_mflop=("expected_mflop", "sum"),
    )
    notes = table.loc[table["notes"] != "", "notes"]
    lines = [f"{len(table)} scenes at tolerance {tolerance:g}:", ""]
    lines.append(summary.to_string(index=False, float_format=lambda value: f"{value:.3g}"))
    doubtful = table[table["status"] != "ok"]
    if len(doubtful):
        lines += ["", f"{len(doubtful)} scenes end otherwise than ok:"]
        lines += [
            f"  {len(alike)} scenes, such as point {alike['point_id'].iloc[0]}: {status}"
            for status, alike in doubtful.groupby("status", sort=False)
        ]
    if len(notes):
        lines += ["", f"{len(notes)} scenes carry notes, such as: {notes.iloc[0]}"]
    return "\n".join(lines)
