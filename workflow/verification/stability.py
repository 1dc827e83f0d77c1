"""Stiff and extreme films, each judged by checks that the solver does not know of.

Verdicts: *solved*, all checks passed; *unchecked*, solved, but no check can be had; *refused*, the
solver says that it cannot and the film lies where that is documented (`films.beyond`); *failed*,
anything else, with the checks that did not pass.

A pressure is carried to a finer grid, where the equation is evaluated in another form and another
program (``numpy_periodic``); what is left is a defect of discretisation, iteration and code alike.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.interpolate import BarycentricInterpolator
from scipy.signal import resample

from squeezefilm.errors import InputError
from squeezefilm.film.validity import check_scene
from squeezefilm.parallel import say
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device
from verification.films import Case, Film, beyond
from verification.marching import FloatArray, Fold
from verification.numpy_periodic import Collocation, chebyshev_grid

TOLERANCE = 1e-4
# A force is solved for again to this share of the tolerance.
FINER = 0.1
# What each check may find. The defect is a first-order estimate of the force's error; a film in
# distress exceeds this by far.
ALLOWED = {
    "method_difference": 2 * TOLERANCE,
    "finer_difference": TOLERANCE,
    "defect": 10 * TOLERANCE,
    "state_defect": 2e-2,
}


def stability(chosen: Sequence[Case], *, device: Device) -> pd.DataFrame:
    """A row for each case: numbers, verdict, every check's deviation, the worst over its bound."""
    rows = []
    for case in chosen:
        row = _judged(case, device=device)
        say(f"{row['case']}: {row['verdict']} {row['reason']}".rstrip())
        rows.append(row)
    return pd.DataFrame(rows)


def _judged(case: Case, *, device: Device) -> dict[str, Any]:
    film = case.film
    row: dict[str, Any] = {
        "case": film.name,
        "group": case.group,
        **{name: getattr(film, name) for name in ("epsilon", "sigma", "bearing", "reynolds")},
    }
    try:
        check_scene(film.scene)
        (solution,) = solve([film.scene], tolerance=TOLERANCE, device=device)
        refusal = "" if solution.status == "ok" else solution.status
    except InputError as error:
        refusal = str(error)
    if refusal:
        why = beyond(film)
        reason = f"{why}: {refusal}" if why else refusal
        return row | {"verdict": "refused" if why else "failed", "reason": reason}
    checks = _checks(film, solution, device=device)
    broken = [name for name, found in checks.items() if not found <= ALLOWED[name]]
    return row | {
        "verdict": "failed" if broken else "solved" if checks else "unchecked",
        "reason": "; ".join(
            f"{name} {checks[name]:.1e} above {ALLOWED[name]:.1e}" for name in broken
        ),
        "method": solution.method,
        "force": solution.force_n / film.scene.force_scale_n,
        "estimated_error": solution.force_error_n / solution.force_n,
        "worst_over_allowed": max(
            (checks[name] / ALLOWED[name] for name in checks), default=math.nan
        ),
        **checks,
    }


def _checks(film: Film, solution: Solution, *, device: Device) -> dict[str, float]:
    """What can be asked of a film's force and state, but for the solver's own estimate."""

    def again(tolerance: float) -> tuple[Solution, float]:
        (found,) = solve(
            [film.scene], tolerance=tolerance, method="periodic", device=device, keep_states=True
        )
        off = abs(found.force_n / solution.force_n - 1) if found.status == "ok" else math.inf
        return found, off

    checks: dict[str, float] = {}
    periodic, off = again(TOLERANCE)
    if not solution.method.startswith("periodic"):
        # A limit's force must be that of the full equation, where that can be had.
        checks["method_difference"] = off
    if film.shape != "rectangle" or film.reynolds:
        # The equation and the pads that the state is checked by have neither: the same but finer.
        _, checks["finer_difference"] = again(FINER * TOLERANCE)
    elif math.isfinite(off):
        grid, (overpressure,) = periodic.states[-1].grid, periodic.states[-1].unknowns
        checks |= check_state(film, unfold(overpressure, (grid.x.folded, grid.y.folded)))
    documented = bool(beyond(film))
    return {name: each for name, each in checks.items() if math.isfinite(each) or not documented}


def unfold(overpressure: FloatArray, fold: Fold) -> FloatArray:
    """The field on the whole finger from that on its mirror half or quarter, (nx, ny, nt)."""
    whole = np.concatenate([overpressure, overpressure[::-1]]) if fold[0] else overpressure
    return np.concatenate([whole, whole[:, ::-1]], axis=1) if fold[1] else whole


def check_state(film: Film, overpressure: FloatArray) -> dict[str, float]:
    """Judge p = P - 1 at the inner Chebyshev points of the whole finger and equal times of a
    period from T = 0, shape (nx, ny, nt).

    Returns:
        ``defect``: change of the force in one correction by the mean-coefficient operator, relative
        to the force; blind to what changes the pressure and not its mean, as by symmetry.
        ``state_defect``: root mean square of that correction relative to the mass perturbation H p.
    """
    nx, ny, nt = (2 * math.ceil(0.625 * n) for n in overpressure.shape)  # a quarter more, and even
    numbers = {name: getattr(film, name) for name in ("sigma", "bearing", "knudsen", "aspect")}
    finer = Collocation(gap=film.scene.gap, nx=nx, ny=ny, nt=nt, **numbers)
    to_x, to_y = (
        BarycentricInterpolator(chebyshev_grid(n).x, np.eye(n + 2), rng=0)(grid.x[1:-1])[:, 1:-1]
        for n, grid in zip(overpressure.shape, (finer.x, finer.y), strict=False)
    )
    p = resample(np.matmul(to_y, np.tensordot(to_x, overpressure, 1)), nt, axis=-1)
    correction = finer.preconditioner(p)(finer.residual(p))
    size = finer.mean((finer.gap * p) ** 2)
    return {
        "defect": abs(finer.mean(correction / finer.gap) / finer.mean(p)),
        "state_defect": math.sqrt(finer.mean(correction**2) / size),
    }
