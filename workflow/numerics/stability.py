"""Stiff and extreme films, each judged by checks that the solver does not know of.

Verdicts: *solved*, all checks passed; *unchecked*, solved, but no check can be had; *refused*, the
solver says that it cannot and the film lies where that is documented (`beyond`); *failed*, anything
else, with the checks that did not pass.
"""

import math
import time
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from numerics import analytic
from numerics.any_gap import cases as any_gap
from numerics.films import PISTON, Film, Rough
from numerics.inertia import cases as with_inertia
from numerics.peers import numpy_periodic
from numerics.peers.explicit_march import step_limit
from numerics.peers.fixed_grid import solve_on_grid
from numerics.state_checks import check_state, unfold
from squeezefilm.film.existence import check_scene
from squeezefilm.film.vibration.shapes import Sinc
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.io.progress import say
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.resolution import finer_grid
from squeezefilm.reynolds.periodic.states import States

TOLERANCE = 1e-4
# The defect is a first-order estimate of the force's error; a film in distress exceeds this by far.
DEFECT = 10 * TOLERANCE
STATE_DEFECT = 2e-2
# Near contact the force answers to a mass error by 1/H: states are iterated well beyond need.
ITERATION = 1e-3 * TOLERANCE
# Local values: in a layer thinner than the grid's spacing they are rougher than the force.
FIELD = {"resolved layer": 1e-2, "thin layer": 0.2}
THIN_LAYER_SIGMA = 1e4
# Round-off alone is left of states that are iterated so far.
SCRAMBLED, SCRAMBLED_ITERATION = 1e-8, 1e-10
SINGLE_PRECISION_TOLERANCE = 1e-6
# Larger grids are not solved anew in single precision or with sums in another order.
SMALL_GRID = 60_000


@dataclass(frozen=True)
class Limit:
    """A force that a film comes close to: by which formula, its value in p0 area, how close."""

    name: str
    force: float
    allowed: float


@dataclass(frozen=True)
class Case:
    """A film with its place in the matrix: group, and whether a small sample has it too."""

    film: Film
    group: str
    in_sample: bool = False


def cases() -> list[Case]:
    """All cases: the plane of sigma and epsilon for two profiles, sliding, shapes, gases."""
    found = [
        Case(
            Film(f"sinc, σ = {_power(sigma)}, ε = {epsilon:g}", epsilon, sigma),
            "sinc",
            in_sample=(sigma, epsilon)
            in {(1e-3, 1e-3), (1e-3, 0.5), (20.0, 0.9), (2331.0, 0.1), (1e5, 0.99)},
        )
        for sigma in (1e-3, 1.0, 20.0, 2331.0, 1e5, 1e7)
        for epsilon in (1e-3, 0.1, 0.5, 0.9, 0.99)
    ]
    found += [
        Case(
            Film(f"piston, σ = {_power(sigma)}, ε = {epsilon:g}", epsilon, sigma, profile=PISTON),
            "piston",
            in_sample=(sigma, epsilon) in {(1e-3, 0.5), (20.0, 1e-3), (1e5, 0.5)},
        )
        for sigma in (1e-3, 20.0, 1e5, 1e7)
        for epsilon in (1e-3, 0.5, 0.9)
    ]
    found += [
        Case(
            Film(f"sliding, Λ = {_power(bearing)}, σ = {_power(sigma)}", 0.4, sigma, bearing),
            "sliding",
            in_sample=(bearing, sigma) in {(100.0, 583.0)},
        )
        for bearing, sigma in (
            (1.0, 583.0),
            (100.0, 1.0),
            (100.0, 583.0),
            (1e3, 583.0),
            (1e3, 1e5),
            (1e4, 583.0),
        )
    ]
    piston = Film("", 0.3, 20.0, profile=PISTON)
    shapes = {
        "node of the profile under the finger": Film("", 0.5, 583.0, profile=Sinc(280.0)),
        "rough measured profile": Film("", 0.4, 583.0, profile=Rough(0.1, 2e-3)),
        "off centre, at the rim of the disc": Film("", 0.4, 2331.0, x=0.293),
        "off centre, diagonal": Film("", 0.4, 2331.0, x=0.2051, y=0.2051),
        "off centre, small amplitude": Film("", 1e-3, 583.0, x=0.2, y=0.1),
        "very thin finger, 1 : 100": replace(piston, epsilon=1e-3, aspect=100.0),
        "very thin finger, 100 : 1": replace(piston, epsilon=1e-3, sigma=2e5, aspect=0.01),
        "1 Hz": Film("", 0.4, 0.054),
        "1 GHz": Film("", 0.4, 5.4e7),
        "rarefied gas, Kn = 0.0134": Film("", 0.44, 1e6, knudsen=0.0134),
        "rarefied gas, Kn = 0.1": Film("", 0.44, 1e6, knudsen=0.1),
        "contact": Film("", 1.0, 583.0),
    }
    sampled = {"rough measured profile", "very thin finger, 1 : 100", "contact"}
    found += [
        Case(replace(film, name=name), "shape, gas, frequency", in_sample=name in sampled)
        for name, film in shapes.items()
    ]
    found += [Case(film, with_inertia.GROUP, in_sample) for film, in_sample in with_inertia.films()]
    found += [Case(film, any_gap.GROUP, in_sample) for film, in_sample in any_gap.films()]
    return found


def beyond(film: Film) -> str:
    """Why a film may be refused; empty inside the region that the solver is documented for."""
    if film.scene.closure() >= 1:
        return "contact"
    if film.scene.closure() > 0.98:
        return "nearer to contact than 2 % of the gap"
    if abs(film.bearing) >= 1e3:
        return "bearing number of 1000 or more"
    if film.sigma > 1e7:
        return "squeeze number above 1e7"
    return with_inertia.beyond(film)


def limit_of(film: Film) -> Limit | None:
    """The analytic limit that a film is nearest to, if any, and how close it must come."""
    if film.reynolds or not film.gap.flat or film.shape != "rectangle":
        return None
    at_rest = film.bearing == 0 and film.knudsen == 0 and film.scene.plain
    eps, sigma = film.epsilon, film.sigma
    square = film.aspect == 1
    piston = film.profile is PISTON
    if at_rest and piston and eps <= 1e-2:
        force = analytic.piston_small_amplitude(epsilon=eps, sigma=sigma, aspect=film.aspect)
        return Limit("piston, ε → 0 (Blech 1983)", force, 3 * eps**2 + TOLERANCE)
    if at_rest and square and eps <= 1e-2:
        force = analytic.small_amplitude(epsilon=eps, sigma=sigma, amplitude=film.amplitude)
        return Limit("ε → 0", force, 3 * eps**2 + TOLERANCE)
    # The film of the smallest gap is the one with the largest local squeeze number.
    local = sigma / (1 - eps) ** 3 if eps < 1 else math.inf
    if at_rest and square and piston and local <= 0.1:
        force = analytic.piston_slow(epsilon=eps, sigma=sigma)
        return Limit("σ → 0", force, local + TOLERANCE)
    if film.bearing == 0 and square and sigma >= 1e5:
        force = analytic.fast(epsilon=eps, amplitude=film.scene.magnitude, knudsen=film.knudsen)
        name = "σ → ∞ with slip" if film.knudsen else "σ → ∞"
        return Limit(name, force, 3 / math.sqrt(sigma) + TOLERANCE)
    return None


@dataclass
class _Judgement:
    """A row that grows, the checks that did not pass, and why there was none."""

    row: dict[str, Any]
    broken: list[str] = field(default_factory=list)
    unchecked: str = ""

    def require(self, name: str, value: float, most: float) -> None:
        self.row[name] = value
        if not value <= most:
            self.broken.append(f"{name} {value:.1e} above {most:.1e}")


def stability(chosen: list[Case], *, device: Device) -> pd.DataFrame:
    """A row for each case, forces in units of p0 times the area; empty what does not apply."""
    rows = []
    for case in chosen:
        row = _judge(case, device=device)
        say(f"{row['case']}: {row['verdict']} {row['reason']}".rstrip())
        rows.append(row)
    return pd.DataFrame(rows)


def _judge(case: Case, *, device: Device) -> dict[str, Any]:
    film = case.film
    judgement = _Judgement(
        {
            "case": film.name,
            "group": case.group,
            "epsilon": film.epsilon,
            "sigma": film.sigma,
            "bearing": film.bearing,
            "reynolds": film.reynolds,
            "profile": type(film.profile).__name__.lower(),
        }
    )
    row = judgement.row
    start = time.perf_counter()
    try:
        check_scene(film.scene)
        (solution,) = solve([film.scene], tolerance=TOLERANCE, device=device)
    except InputError as error:
        return _refused(film, row, str(error))
    row["wall_seconds"] = time.perf_counter() - start
    row["method"] = solution.method
    if solution.status != "ok":
        return _refused(film, row, solution.status)
    force = solution.force_n / film.scene.force_scale_n
    row["force"] = force
    row["estimated_error"] = solution.force_error_n / solution.force_n
    limit = limit_of(film)
    if limit is not None:
        row |= {"limit": limit.name, "limit_force": limit.force, "limit_allowed": limit.allowed}
        judgement.require("limit_difference", abs(force / limit.force - 1), limit.allowed)
    periodic = solution
    if not solution.method.startswith("periodic"):
        # A limit's force must be that of the full equation, where that can be had.
        (periodic,) = solve([film.scene], tolerance=TOLERANCE, method="periodic", device=device)
        if periodic.status == "ok":
            judgement.require(
                "method_difference", abs(periodic.force_n / solution.force_n - 1), 2 * TOLERANCE
            )
    row |= {
        name: getattr(periodic, name)
        for name in ("residual", "newton_steps", "krylov_iterations", "nx", "ny", "nt")
    }
    if periodic.status == "ok":
        force = periodic.force_n / film.scene.force_scale_n
        check = _check_inertia if film.reynolds else _check_periodic
        if film.shape != "rectangle":
            check = _check_in_modes
        check(judgement, film, periodic, force, device=device)
    elif not beyond(film):
        judgement.broken.append(f"periodic state: {periodic.status}")
    row["verdict"] = "unchecked" if judgement.unchecked else "solved"
    row["reason"] = judgement.unchecked
    if judgement.broken:
        row["verdict"], row["reason"] = "failed", "; ".join(judgement.broken)
    return row


def _refused(film: Film, row: dict[str, Any], why: str) -> dict[str, Any]:
    documented = beyond(film)
    row["verdict"] = "refused" if documented else "failed"
    row["reason"] = f"{documented}: {why}" if documented else why
    return row


def _check_periodic(
    judgement: _Judgement, film: Film, solution: Solution, force: float, *, device: Device
) -> None:
    """Checks of the pressure itself, solved again on the grid that the force was found on."""
    fold = film.fold
    grid = Grid(
        nx=solution.nx // (1 + fold[0]),
        ny=solution.ny // (1 + fold[1]),
        nt=solution.nt,
        fold_x=fold[0],
        fold_y=fold[1],
    )

    states = solve_on_grid([film], grid=grid, tolerance=ITERATION, device=device)
    checks = check_state(film, unfold(states.overpressure[0], fold))
    row = judgement.row
    row["lowest_pressure"] = checks.lowest_pressure
    if not checks.lowest_pressure > 0:
        judgement.broken.append(f"pressure falls to {checks.lowest_pressure:.1e}")
    judgement.require("defect", checks.defect, DEFECT)
    judgement.require("state_defect", checks.state_defect, STATE_DEFECT)
    # A force is good on grids too coarse for its field everywhere: that is looked at on the next
    # but one.
    finer = finer_grid(grid) or grid
    finer = finer_grid(finer) or finer
    there = solve_on_grid([film], grid=finer, tolerance=ITERATION, device=device)
    of_field = check_state(film, unfold(there.overpressure[0], fold))
    local = FIELD["thin layer" if film.sigma > THIN_LAYER_SIGMA else "resolved layer"]
    judgement.require("mass_balance", of_field.mass_balance, local)
    if np.isfinite(of_field.piston_identity):
        judgement.require("piston_identity", of_field.piston_identity, local)
    if not abs(checks.force / force - 1) <= DEFECT:
        judgement.broken.append(f"force {checks.force:.6g} on the same grid, iterated further")
    if solution.nx * solution.ny * solution.nt > SMALL_GRID:
        return
    plain = solve_on_grid([film], grid=grid, tolerance=SCRAMBLED_ITERATION, device=device)
    scrambled = _scrambled(film, grid, device=device)
    difference = abs(float(scrambled.mean[0] / plain.mean[0]) - 1)
    judgement.require("scrambled_difference", difference, SCRAMBLED)
    if film.aspect == 1 and film.knudsen == 0 and film.scene.plain:
        row["single_precision_difference"] = _single_precision(film, solution, force)


def _check_inertia(
    judgement: _Judgement, film: Film, solution: Solution, force: float, *, device: Device
) -> None:
    """The equation that the other checks know has no inertia: the same state, but finer."""
    finer = with_inertia.on_a_finer_grid(film, solution, tolerance=0.1 * TOLERANCE, device=device)
    if finer is not None:
        judgement.require("finer_difference", abs(finer / force - 1), TOLERANCE)
    elif beyond(film):
        judgement.unchecked = with_inertia.NOT_CHECKED
    else:
        judgement.broken.append(with_inertia.NOT_CHECKED)


def _check_in_modes(
    judgement: _Judgement, film: Film, solution: Solution, force: float, *, device: Device
) -> None:
    """The other checks know rectangles alone: the same film to a tenth of the tolerance."""
    (finer,) = solve([film.scene], tolerance=0.1 * TOLERANCE, method="periodic", device=device)
    if finer.status != "ok":
        judgement.broken.append(f"to a tenth of the tolerance: {finer.status}")
    judgement.require("finer_difference", abs(finer.force_n / solution.force_n - 1), TOLERANCE)


def _scrambled(film: Film, grid: Grid, *, device: Device) -> States:
    """The same collocation with all sums in another order: on the whole finger if symmetry had
    saved a part of it, mirrored along y if not."""
    if grid.fold_x or grid.fold_y:
        whole = Grid(grid.x.full_points, grid.y.full_points, grid.nt, fold_x=False, fold_y=False)
        other = film
    else:
        whole, other = grid, film.mirrored
    return solve_on_grid([other], grid=whole, tolerance=SCRAMBLED_ITERATION, device=device)


def _single_precision(film: Film, solution: Solution, force: float) -> float:
    """Relative change of the force when all is done in float32; infinite where that fails."""
    try:
        state = numpy_periodic.periodic_state(
            epsilon=film.epsilon,
            sigma=film.sigma,
            amplitude=film.amplitude,
            bearing=film.bearing,
            nx=solution.nx,
            ny=solution.ny,
            nt=solution.nt,
            tolerance=SINGLE_PRECISION_TOLERANCE,
            dtype=np.float32,
        )
    except RunError:
        return math.inf
    return abs(state.force / force - 1)


def explicit_limits() -> pd.DataFrame:
    """The step limit of an explicit march, by experiment and by theory, as rows of that table."""
    return pd.DataFrame([_explicit_limit(sigma) for sigma in (20.0, 583.0)])


def _explicit_limit(sigma: float) -> dict[str, Any]:
    """Steps a period that an explicit march needs: by experiment, and by theory."""
    found = step_limit(sigma=sigma, points=12)
    difference = abs(found.experiment / found.theory - 1)
    solved = difference <= 0.05
    return {
        "case": f"explicit march, step limit at σ = {_power(sigma)}",
        "group": "explicit march",
        "epsilon": found.epsilon,
        "sigma": sigma,
        "bearing": 0.0,
        "reynolds": 0.0,
        "profile": "sinc",
        "verdict": "solved" if solved else "failed",
        "reason": f"{found.experiment:.0f} steps a period by experiment, {found.theory:.0f} by "
        "theory",
        "method": "Runge-Kutta 4",
        "limit": "stability limit of Runge-Kutta 4, steps a period",
        "limit_force": found.theory,
        "force": found.experiment,
        "limit_difference": difference,
        "limit_allowed": 0.05,
    }


def _power(value: float) -> str:
    if value in (0, 1) or (abs(math.log10(value)) < 4 and value >= 0.1):
        return f"{value:g}"
    return f"1e{round(math.log10(value))}"
