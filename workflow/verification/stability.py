"""Stiff and extreme films, each judged by checks that the solver does not know of.

Verdicts: *solved*, all checks passed; *unchecked*, solved, but no check can be had; *refused*, the
solver says that it cannot and the film lies where that is documented (`cases.beyond`); *failed*,
anything else, with the checks that did not pass.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from squeezefilm.errors import InputError
from squeezefilm.film.validity import check_scene
from squeezefilm.parallel import say
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import States, solve_batch
from verification import analytic
from verification.cases import Case, beyond
from verification.films import Film
from verification.state_checks import check_state, unfold

TOLERANCE = 1e-4
# The defect is a first-order estimate of the force's error; a film in distress exceeds this by far.
DEFECT = 10 * TOLERANCE
STATE_DEFECT = 2e-2
# Near contact the force answers to a mass error by 1/H: states are iterated well beyond need.
ITERATION = 1e-3 * TOLERANCE


class Check(NamedTuple):
    """A relative deviation that was found, and the largest that is allowed."""

    name: str
    found: float
    allowed: float


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
        "epsilon": film.epsilon,
        "sigma": film.sigma,
        "bearing": film.bearing,
        "reynolds": film.reynolds,
    }
    try:
        check_scene(film.scene)
        (solution,) = solve([film.scene], tolerance=TOLERANCE, device=device)
        refusal = "" if solution.status == "ok" else solution.status
    except InputError as error:
        refusal = str(error)
    if refusal:
        why = beyond(film)
        return row | (
            {"verdict": "refused", "reason": f"{why}: {refusal}"}
            if why
            else {"verdict": "failed", "reason": refusal}
        )
    checks = list(_checks(film, solution, device=device))
    broken = [each for each in checks if not each.found <= each.allowed]
    return row | {
        "verdict": "failed" if broken else "solved" if checks else "unchecked",
        "reason": "; ".join(
            f"{each.name} {each.found:.1e} above {each.allowed:.1e}" for each in broken
        ),
        "method": solution.method,
        "force": solution.force_n / film.scene.force_scale_n,
        "estimated_error": solution.force_error_n / solution.force_n,
        "worst_over_allowed": max((each.found / each.allowed for each in checks), default=math.nan),
        **{each.name: each.found for each in checks},
    }


def _checks(film: Film, solution: Solution, *, device: Device) -> Iterator[Check]:
    """What can be asked of a film's force and state, but for the solver's own estimate."""
    if limit := analytic_limit(film):
        off = abs(solution.force_n / film.scene.force_scale_n / limit[0] - 1)
        yield Check("limit_difference", off, limit[1])
    periodic = solution
    if not solution.method.startswith("periodic"):
        # A limit's force must be that of the full equation, where that can be had.
        (periodic,) = solve([film.scene], tolerance=TOLERANCE, method="periodic", device=device)
        if periodic.status != "ok":
            if not beyond(film):
                yield Check("method_difference", math.inf, 2 * TOLERANCE)
            return
        off = abs(periodic.force_n / solution.force_n - 1)
        yield Check("method_difference", off, 2 * TOLERANCE)
    if film.shape != "rectangle":
        # The other checks know rectangles alone: the same film to a tenth of the tolerance.
        tenth = 0.1 * TOLERANCE
        (finer,) = solve([film.scene], tolerance=tenth, method="periodic", device=device)
        off = abs(finer.force_n / solution.force_n - 1) if finer.status == "ok" else math.inf
        yield Check("finer_difference", off, TOLERANCE)
    elif film.reynolds:
        # The equation that the other checks know has no inertia: the same state, but finer.
        grid = _grid(film, *(_more(getattr(periodic, name)) for name in ("nx", "ny", "nt")))
        states = _on_grid(film, grid, tolerance=0.1 * TOLERANCE, device=device)
        if states.status[0] == 0:
            force = periodic.force_n / film.scene.force_scale_n
            yield Check("finer_difference", abs(states.mean[0] / force - 1), TOLERANCE)
        elif not beyond(film):
            yield Check("finer_difference", math.inf, TOLERANCE)
    else:
        yield from _of_state(film, periodic, device=device)


def _of_state(film: Film, solution: Solution, *, device: Device) -> Iterator[Check]:
    """Of the pressure itself, solved again on the grid that the force was found on."""
    grid = _grid(film, solution.nx, solution.ny, solution.nt)
    states = _on_grid(film, grid, tolerance=ITERATION, device=device)
    state = check_state(film, unfold(states.overpressure[0], film.fold))
    force = solution.force_n / film.scene.force_scale_n
    yield Check("iterated_difference", abs(state.force / force - 1), DEFECT)
    yield Check("defect", state.defect, DEFECT)
    yield Check("state_defect", state.state_defect, STATE_DEFECT)


def _grid(film: Film, nx: int, ny: int, nt: int) -> Grid:
    """Of so many points across the whole finger."""
    fold_x, fold_y = film.fold
    return Grid(nx // (1 + fold_x), ny // (1 + fold_y), nt, fold_x=fold_x, fold_y=fold_y)


def _more(points: int) -> int:
    """A quarter more, of a half too."""
    return points + 8 * max(1, round(points / 32))


def _on_grid(film: Film, grid: Grid, *, tolerance: float, device: Device) -> States:
    """The periodic state; the tolerance is of the force, for what Newton's method may leave."""
    return solve_batch([film.scene], grid, tolerance=tolerance, device=device)


def analytic_limit(film: Film) -> tuple[float, float] | None:
    """The force of the limit that a film is nearest to, if any, and how close it must come."""
    square = film.shape == "rectangle" and film.aspect == 1
    if film.reynolds or film.bearing or not film.gap.flat or not square:
        return None
    eps, sigma = film.epsilon, film.sigma
    if eps <= 1e-2 and film.knudsen == 0 and not film.scene.actuator.profile.is_complex:
        force = analytic.small_amplitude(epsilon=eps, sigma=sigma, amplitude=film.amplitude)
        return force, 3 * eps**2 + TOLERANCE
    if sigma >= 1e5:
        magnitude = lambda x, y: np.abs(film.scene.amplitude(x, y))  # noqa: E731
        force = analytic.fast(epsilon=eps, amplitude=magnitude, knudsen=film.knudsen)
        return force, 3 / math.sqrt(sigma) + TOLERANCE
    return None
