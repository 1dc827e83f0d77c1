"""Stiff and extreme films, each with checks that are independent of the solver.

Verdicts: *solved*, all checks passed; *unchecked*, solved, but no check can be had; *not
supported*, the solver says so and the film lies where that is documented (`films.beyond_reason`);
*failed*, anything else, with the checks that did not pass.

A pressure is carried to a finer grid, where the equation is evaluated in another form and another
program (``numpy_periodic``); the residual is that of discretisation, iteration and code together.
"""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.errors import InputError
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import check_scene
from squeezefilm.parallel import print_step
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.periodic.launch import States
from squeezefilm.reynolds.spectral import period
from squeezefilm_workflow.verification.films import beyond_reason
from squeezefilm_workflow.verification.numpy_periodic import Collocation

TOLERANCE = 1e-4
# A force is solved for again to this share of the tolerance.
FINER_RATIO = 0.1
# What each check may find. The residual is a first-order estimate of the force's error; a film in
# distress exceeds this by far.
ALLOWED_DEVIATIONS = {
    "method_difference": 2 * TOLERANCE,
    "finer_difference": TOLERANCE,
    "residual": 10 * TOLERANCE,
    "state_residual": 2e-2,
}


def stability(chosen: Iterable[tuple[str, Scene]], *, device: Device) -> pd.DataFrame:
    """A row for each case: numbers, verdict, every check's deviation, the worst over its bound."""
    rows = []
    for group, scene in chosen:
        inert = scene.gas.inertia == "included"
        row = {
            "case": scene.point_id,
            "group": group,
            "epsilon": round(scene.epsilon, 6),
            "sigma": round(scene.sigma, 6),
            "bearing_number": round(scene.bearing_number, 6),
            "modified_reynolds": round(scene.modified_reynolds, 6) if inert else 0.0,
            **_row_of_film(scene, device=device),
        }
        print_step(f"{row['case']}: {row['verdict']} {row['reason']}".rstrip())
        rows.append(row)
    return pd.DataFrame(rows)


def _row_of_film(scene: Scene, *, device: Device) -> dict[str, Any]:
    why = beyond_reason(scene)
    try:
        check_scene(scene)
        (solution,) = solve([scene], tolerance=TOLERANCE, device=device, keep_states=True)
        refusal = "" if solution.status == "ok" else solution.status
    except InputError as error:
        refusal = str(error)
    if refusal:
        reason = f"{why}: {refusal}" if why else refusal
        return {"verdict": "not supported" if why else "failed", "reason": reason}
    checks = _checks(scene, solution, device=device)
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


def _checks(scene: Scene, solution: Solution, *, device: Device) -> dict[str, float]:
    """Return the independent checks of a film's force and state."""

    def again(tolerance: float) -> tuple[Solution, float]:
        (found,) = solve(
            [scene], tolerance=tolerance, method="periodic", device=device, keep_states=True
        )
        off = abs(found.force_n / solution.force_n - 1) if found.status == "ok" else math.inf
        return found, off

    checks: dict[str, float] = {}
    periodic, off = solution, 0.0
    if solution.method != "periodic":
        # A limit's force must be that of the full equation, where that can be had.
        periodic, off = again(TOLERANCE)
        checks["method_difference"] = off
    if scene.pad.shape != "rectangle" or scene.gas.inertia == "included":
        # The equation and the pads that the state is checked by have neither: the same but finer.
        _, checks["finer_difference"] = again(FINER_RATIO * TOLERANCE)
    elif math.isfinite(off):
        checks |= check_state(scene, periodic.states[-1])
    return checks


def check_state(scene: Scene, state: States) -> dict[str, float]:
    """Check a periodic state.

    Returns:
        ``residual``: change of the force in one correction by the mean-coefficient operator,
        relative to the force; blind to what changes the pressure and not its mean, as by symmetry.
        ``state_residual``: root mean square of that correction over the mass perturbation H p.
    """
    grid, in_time = state.grid, period(state.grid.nt)
    known = grid.x.full_points, grid.y.full_points, grid.nt
    nx, ny, nt = (2 * math.ceil(0.625 * n) for n in known)  # a quarter more, and even
    finer = Collocation(scene, nx=nx, ny=ny, nt=nt)
    at = grid.x.at(finer.x.x[1:-1]), grid.y.at(finer.y.x[1:-1]), in_time.at(period(nt).nodes)
    p = np.einsum("xa,yb,ti,abi->xyt", *at, state.unknowns[0], optimize=True)
    correction = finer.preconditioner(p)(finer.residual(p))
    size = finer.mean((finer.gap * p) ** 2)
    return {
        "residual": abs(finer.mean(correction / finer.gap) / finer.mean(p)),
        "state_residual": math.sqrt(finer.mean(correction**2) / size),
    }
