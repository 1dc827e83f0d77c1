"""Stiff and extreme films, each with checks that are independent of the solver.

Verdicts: *solved*, all checks passed; *unchecked*, solved, but no check can be had; *not
supported*, the solver says so and the film lies where that is documented
(`films.outside_region_reason`); *failed*, anything else, with the checks that did not pass.

A pressure is carried to a finer grid, where the equation is evaluated in another form and another
program (``numpy_periodic``); the residual is that of discretisation, iteration and code together.
A film with inertia or under an ellipse is solved by another program (``all_effects``), on a finer
grid than the solver's.
"""

import argparse
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.cli.options import command, option
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import check_scene
from squeezefilm.parallel import print_step
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.periodic.launch import PeriodicStates
from squeezefilm.reynolds.spectral import cached_time_axis
from squeezefilm.reynolds.terms import terms_label, terms_of
from squeezefilm.table_writer import write_table
from squeezefilm_workflow.verification.all_effects import Effects, force_on_grid, is_axisymmetric
from squeezefilm_workflow.verification.films import (
    SHAPE_OF_PAD_NAME,
    films_with_effects,
    outside_region_reason,
    waves_steepen,
)
from squeezefilm_workflow.verification.marching import film_symmetry_in_x_and_y
from squeezefilm_workflow.verification.numpy_periodic import CollocatedFilm
from squeezefilm_workflow.verification.origin import write_with_origin

TOLERANCE = 1e-4
# A force is solved for again to this share of the tolerance.
FINER_TOLERANCE_RATIO = 0.1
# Nodes and instants of a check over those of the solver's grid.
FINER_GRID_RATIO = 1.25
# Points times instants of the other program, whose matrices are dense: a film takes seconds.
MAX_INDEPENDENT_UNKNOWNS = 12_500
# What each check may find. The residual is a first-order estimate of the force's error; a film in
# distress exceeds this by far.
ALLOWED_DEVIATIONS = {
    "method_difference": 2 * TOLERANCE,
    "finer_difference": TOLERANCE,
    "independent_difference": TOLERANCE,
    "residual": 10 * TOLERANCE,
    "state_residual": 2e-2,
}


@command(
    option("--output", "TABLE.csv", "table of films to write", required=True, type=Path),
    option("--summary", "SUMMARY.csv", "its counts and deviations", required=True, type=Path),
)
def stability_plane(options: argparse.Namespace) -> None:
    """Judge discs and squares with inertia and thermal effects.

      squeezefilm-verification stability-plane --output TABLE.csv --summary SUMMARY.csv

    The films span Re 0.1 to 20, σ 1 to 1e5 and ε 0.1 to 0.9. The exit status is 1 where one fails.
    """
    films = (("", scene) for pad in SHAPE_OF_PAD_NAME for scene in films_with_effects(pad))
    table = stability_table(films, device=choose_device())
    write_table(table, options.output)
    summary = verdict_summary(table)
    call = "stability-plane --output TABLE.csv --summary SUMMARY.csv"
    about = (
        "verdicts by pad and Re; largest relative differences from finer grids and another program"
    )
    write_with_origin(summary, options.summary, command=call, about=about)
    print(summary.to_csv(index=False))
    raise_if_film_failed(table)


def verdict_summary(table: pd.DataFrame) -> pd.DataFrame:
    """Counts of verdicts and the largest deviations by pad and Reynolds number."""
    films = [
        table["case"].str.partition(",")[0].rename("pad"),
        table["modified_reynolds"].rename("Re"),
    ]
    counts = pd.crosstab(films, table["verdict"])
    table = table.replace(math.inf, math.nan)  # not solved at the finer tolerance
    compared = table["independent_difference"].groupby(films).count().rename("compared")
    largest = table.groupby(films)[["finer_difference", "independent_difference"]].max()
    largest = largest.map(lambda value: f"{value:.1e}" if math.isfinite(value) else "–")
    largest.columns = ["largest finer difference", "largest independent difference"]
    return counts.join([compared, largest]).reset_index()


def raise_if_film_failed(table: pd.DataFrame) -> None:
    """Raise RunError where a film of a table has failed."""
    failed = table[table["verdict"] == "failed"]
    if len(failed):
        named = "; ".join(f"{row.case}: {row.reason}" for row in failed.itertuples())
        raise RunError(f"{len(failed)} of {len(table)} cases failed: {named}")


def stability_table(chosen: Iterable[tuple[str, Scene]], *, device: Device) -> pd.DataFrame:
    """A row for each case: numbers, verdict, every check's deviation, the worst over its bound."""
    rows = []
    for group, scene in chosen:
        inert = scene.gas.inertia == "included"
        row = {
            "case": scene.point_id,
            "group": group,
            "terms": terms_label(terms_of(scene)),
            "epsilon": round(scene.epsilon, 6),
            "sigma": round(scene.sigma, 6),
            "bearing_number": round(scene.bearing_number, 6),
            "modified_reynolds": round(scene.modified_reynolds, 6) if inert else 0.0,
            **_stability_row(scene, device=device),
        }
        print_step(f"{row['case']}: {row['verdict']} {row['reason']}".rstrip())
        rows.append(row)
    return pd.DataFrame(rows)


def _stability_row(scene: Scene, *, device: Device) -> dict[str, Any]:
    why = outside_region_reason(scene)
    try:
        check_scene(scene)
        (solution,) = solve([scene], tolerance=TOLERANCE, device=device, keep_states=True)
        refusal = "" if solution.status == "ok" else solution.status
    except InputError as error:
        refusal = str(error)
    if refusal:
        reason = f"{why}: {refusal}" if why else refusal
        return {"verdict": "not supported" if why else "failed", "reason": reason}
    checks = _deviations_of_checks(scene, solution, device=device)
    checks = {name: each for name, each in checks.items() if math.isfinite(each) or not why}
    shares = {name: each / ALLOWED_DEVIATIONS[name] for name, each in checks.items()}
    broken = [name for name, share in shares.items() if not share <= 1]
    return {
        "verdict": "failed" if broken else "solved" if checks else "unchecked",
        "reason": "; ".join(
            f"{name} {checks[name]:.1e} above {ALLOWED_DEVIATIONS[name]:.1e}" for name in broken
        ),
        "method": solution.method,
        "force": solution.force_n / scene.force_scale_n,
        "estimated_error": solution.force_error_n / solution.force_n,
        "worst_ratio": max(shares.values(), default=math.nan),
        **checks,
    }


def _deviations_of_checks(scene: Scene, solution: Solution, *, device: Device) -> dict[str, float]:
    """Return the independent checks of a film's force and state."""

    def solve_again(tolerance: float) -> tuple[Solution, float]:
        (repeated,) = solve(
            [scene], tolerance=tolerance, method="periodic", device=device, keep_states=True
        )
        off = abs(repeated.force_n / solution.force_n - 1) if repeated.status == "ok" else math.inf
        return repeated, off

    checks: dict[str, float] = {}
    periodic, off = solution, 0.0
    if solution.method != "periodic":
        # A limit's force must be that of the full equation, where that can be had.
        periodic, off = solve_again(TOLERANCE)
        checks["method_difference"] = off
    if scene.pad.shape != "rectangle" or scene.gas.inertia == "included":
        finer, checks["finer_difference"] = solve_again(FINER_TOLERANCE_RATIO * TOLERANCE)
        independent_n = independent_force(scene, finer if finer.status == "ok" else periodic)
        if math.isfinite(independent_n):
            checks["independent_difference"] = abs(solution.force_n / independent_n - 1)
    elif math.isfinite(off):
        checks |= state_deviations(scene, periodic.states[-1])
    return checks


def independent_force(scene: Scene, solution: Solution) -> float:
    """Return the force in newtons of another program on a finer grid than the solution's.

    NaN where it has none: its grid would be larger than MAX_INDEPENDENT_UNKNOWNS, it does not
    converge, or waves steepen, where it takes minutes to find that out.
    """
    if scene.gas.inertia == "included" and waves_steepen(scene):
        return math.nan
    points = 4 * math.ceil(FINER_GRID_RATIO * (max(solution.nx, solution.ny) + 2) / 4)
    instants = math.ceil(FINER_GRID_RATIO * solution.nt) // 2 * 2 + 1
    size = instants * points**2 / 2 ** sum(film_symmetry_in_x_and_y(scene))
    if size > MAX_INDEPENDENT_UNKNOWNS and not is_axisymmetric(scene):
        return math.nan
    try:
        return force_on_grid(scene, Effects.of_scene(scene), points=points, instants=instants)
    except ArithmeticError:
        return math.nan


def state_deviations(scene: Scene, state: PeriodicStates) -> dict[str, float]:
    """Check a periodic state.

    Returns:
        ``residual``: change of the force in one correction by the mean-coefficient operator,
        relative to the force; blind to what changes the pressure and not its mean, as by symmetry.
        ``state_residual``: root mean square of that correction over the mass perturbation H p.
    """
    grid, in_time = state.grid, cached_time_axis(state.grid.nt)
    known = grid.x.full_point_count, grid.y.full_point_count, grid.nt
    nx, ny, nt = (2 * math.ceil(0.625 * n) for n in known)  # a quarter more, and even
    finer = CollocatedFilm(scene, nx=nx, ny=ny, nt=nt)
    at = (
        grid.x.matrix_at(finer.x.x[1:-1]),
        grid.y.matrix_at(finer.y.x[1:-1]),
        in_time.matrix_at(cached_time_axis(nt).nodes),
    )
    p = np.einsum("xa,yb,ti,abi->xyt", *at, state.unknowns[0], optimize=True)
    correction = finer.preconditioner(p)(finer.residual(p))
    size = finer.mean_force((finer.gap * p) ** 2)
    return {
        "residual": abs(finer.mean_force(correction / finer.gap) / finer.mean_force(p)),
        "state_residual": math.sqrt(finer.mean_force(correction**2) / size),
    }
