"""What each scene needs: method, domain, terms, points, what is left out and why.

  squeezefilm explain SCENES.csv --config CONFIG.yaml
  squeezefilm explain SCENES.csv --config CONFIG.yaml --output EXPLAINED.csv

No force is solved for. The expected error is relative, the expected cost in millions of
floating-point operations. What the Reynolds equation itself leaves out is found on a coarse grid,
in per cent of the force (`squeezefilm budget` has its columns alone); notes name what is large.
`validity` is `ok`, or the limits of validity of the film equation that a scene exceeds.
Where the study has `outputs`, `outputs_refused` says which of them a scene will lack and why.
"""

import argparse

import pandas as pd

from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import OK, validity
from squeezefilm.io.errors import naming
from squeezefilm.io.tables import read_scenes, scene_points, write_table
from squeezefilm.quantities.model_error import (
    NAMES,
    ErrorBudget,
    budget_row,
    error_budgets,
    notes_of_budget,
)
from squeezefilm.quantities.outputs import refusals
from squeezefilm.reynolds.explain import Explanation, explain
from squeezefilm.reynolds.terms import notes_of
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import (
    SolverSettings,
    add_solver_arguments,
    device_of,
    solver_settings,
)
from squeezefilm.studies.study import scene_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", metavar="SCENES.csv", help="table of scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", metavar="EXPLAINED.csv", help="table to write, with every row")
    parser.add_argument(
        "--device", help="instead of SQUEEZEFILM_DEVICE and the config's solver.device"
    )
    add_solver_arguments(parser)


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    settings = solver_settings(config, tolerance=options.tolerance, method=options.method)
    points = scene_points(read_scenes(options.scenes))
    with naming(options.scenes):
        scenes = [scene_of(point, config) for point in points]
    device = device_of(config, option=options.device)
    scenes = settings.resolved(scenes, device)
    explanations = explain(scenes, tolerance=settings.tolerance, method=settings.method)
    left_out = error_budgets(scenes, device=device)
    table = pd.DataFrame([_row(*each) for each in zip(scenes, explanations, left_out, strict=True)])
    if settings.outputs:
        missing = [asked_in_vain(scene, settings) for scene in scenes]
        table["outputs_refused"] = missing
    if options.output is not None:
        write_table(table, options.output)
    print(_summary(table, tolerance=settings.tolerance))


def asked_in_vain(scene: Scene, settings: SolverSettings) -> str:
    """The study's outputs that the scene will not have, or not whole, and why."""
    found = refusals(scene, tolerance=settings.tolerance)
    return "; ".join(f"{name}: {found[name]}" for name in settings.outputs if name in found)


def _row(scene: Scene, explanation: Explanation, budget: ErrorBudget) -> dict[str, object]:
    budget_columns = {f"budget_{name}": value for name, value in budget_row(budget).items()}
    return {
        "point_id": scene.point_id,
        "epsilon": scene.epsilon,
        "sigma": scene.sigma,
        "bearing_number": scene.bearing_number,
        "knudsen": scene.knudsen,
        "modified_reynolds": scene.modified_reynolds,
        "method": explanation.method,
        "status": explanation.status,
        "validity": validity(scene),
        "domain": explanation.domain,
        "terms": "; ".join(explanation.terms),
        "nx": explanation.nx,
        "ny": explanation.ny,
        "nt": explanation.nt,
        "left_out": "; ".join(part.what for part in explanation.left_out),
        "why": "; ".join(f"{part.what}: {part.why}" for part in explanation.left_out),
        "expected_error": explanation.expected_error,
        "expected_mflop": explanation.expected_mflop,
        **budget_columns,
        "notes": "; ".join((*notes_of(scene), *notes_of_budget(budget))),
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
    beyond = [
        f"{name} {table[column].min():+.2g} … {table[column].max():+.2g}"
        for name in NAMES
        if table[column := f"budget_{name}_percent"].abs().max() > 0
    ]
    lines = [f"{len(table)} scenes at tolerance {tolerance:g}:", ""]
    lines.append(summary.to_string(index=False, float_format=lambda value: f"{value:.3g}"))
    doubtful = table[table["status"] != "ok"]
    if len(doubtful):
        lines += ["", f"{len(doubtful)} scenes end otherwise than ok:"]
        lines += [
            f"  {len(alike)} scenes, such as point {alike['point_id'].iloc[0]}: {status}"
            for status, alike in doubtful.groupby("status", sort=False)
        ]
    beyond_limits = table[table["validity"] != OK]
    lines += [
        f"{len(alike)} scenes, such as point {alike['point_id'].iloc[0]}, are outside: {words}"
        for words, alike in beyond_limits.groupby("validity", sort=False)
    ]
    if "outputs_refused" in table:
        lines += [
            f"{len(alike)} scenes, such as point {alike['point_id'].iloc[0]}, lack {refused}"
            for refused, alike in table[table["outputs_refused"] != ""].groupby("outputs_refused")
        ]
    if beyond:
        what = "beyond the equation, in per cent of the force (the rim for C = 1)"
        lines += ["", f"{what}: {', '.join(beyond)}"]
    if len(notes):
        lines += ["", f"{len(notes)} scenes carry notes, such as: {notes.iloc[0]}"]
    return "\n".join(lines)
