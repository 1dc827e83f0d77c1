"""Derivatives of the mean force to gap, amplitude, position and the gas' numbers: one adjoint.

With the film's residual R(P, θ) = 0 of an unknown P and a number θ, the mean pressure changes by
⟨λ S⟩ per change of θ, with S = −∂R/∂θ at the film's own P and λ the answer to any source of mass
(adjoint.py), solved for once and not for each number. S is a difference of residuals: no film is
solved for another θ. All is done on the kept states' two grids, whose difference gives the error.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.adjoint import (
    Fields,
    Solved,
    alike,
    fields_of,
    remainder,
    sensitivity,
    with_states,
)
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.problems import numbers_table, problems_of
from squeezefilm.reynolds.terms import terms_of
from squeezefilm.reynolds.terms.bearing import Bearing
from squeezefilm.reynolds.terms.gap import AnyGap
from squeezefilm.reynolds.terms.outline import SmoothOutline
from squeezefilm.reynolds.terms.polytropic import Polytropic
from squeezefilm.reynolds.terms.rarefaction import Rarefaction
from squeezefilm.solution import DERIVATIVES, Derivatives, Solution

# Terms of the equation that ``residual`` and the adjoint have.
KNOWN = (AnyGap, Bearing, Polytropic, Rarefaction, SmoothOutline)
# Below this, iterations would end in rounding.
LEAST_TOLERANCE = 1e-8
# Share of the tolerance, times ε, that the adjoint may leave: a source of order ε makes a force of
# its square.
ADJOINT_SHARE, LEAST_LEFT = 1e-4, 1e-12
# A derivative's change from grid to grid is no less than this share of the largest of a scene's:
# without it 15 of 5156 of 200 random films were off by up to 8 times their error.
SHARE_OF_OTHERS = 0.3
# The step of a difference of residuals, of a number's unit.
STEP = 3e-5
# What such a difference misses, as a share of the size of its parts: its third order and rounding.
STEP_MISSES = 1e-8
NOT_FOUND = "not converged: GMRES for the adjoint problem of the derivatives"
# Unknowns that the host's Krylov vectors have room for, and of a group that stays in the caches.
MOST_UNKNOWNS, MOST_TOGETHER = 200_000, 2**15


def with_derivatives(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution],
    *,
    tolerance: float,
    device: Device | None = None,
) -> list[Solution]:
    """The scenes' forces, as ``solve`` gave them, with derivatives, by the states if it kept them.

    They are those of the periodic state, by whichever method its force was found.
    """
    tolerance = max(tolerance, LEAST_TOLERANCE)
    found = [Derivatives(status=_refused(*each)) for each in zip(scenes, solutions, strict=True)]
    known = [k for k, each in enumerate(found) if each.status == "ok"]
    films, forces = [scenes[k] for k in known], [solutions[k] for k in known]
    solved: Solved = {}
    for k, solution in zip(
        known, with_states(films, forces, tolerance=tolerance, device=device), strict=True
    ):
        if not solution.states:
            found[k] = Derivatives(status=solution.status)
        elif solution.states[-1].grid.count > MOST_UNKNOWNS:
            reason = f"derivatives to {tolerance:g} want more than {MOST_UNKNOWNS} unknowns"
            found[k] = Derivatives(status=reason)
        else:
            solved[k] = scenes[k], solution
    for group in alike(solved, numbers=MOST_TOGETHER):
        for k, each in zip(group, _derivatives(group, tolerance=tolerance), strict=True):
            found[k] = each
    return [replace(solution, derivatives=found[k]) for k, solution in enumerate(solutions)]


def _refused(scene: Scene, solution: Solution) -> str:
    """Return the reason for missing derivatives that is known before solving, or ``ok``."""
    if not isfinite(solution.force_n):
        return "no force"
    if unknown := [term.label for term in terms_of(scene) if not isinstance(term, KNOWN)]:
        return f"derivatives are not known with {unknown[0]}: its adjoint is not"
    return "ok"


def _derivatives(group: Solved, *, tolerance: float) -> list[Derivatives]:
    """Derivatives of scenes of like terms, by two grids."""
    scenes, solutions = zip(*group.values(), strict=True)
    with np.errstate(all="ignore"):
        (before, _), (growth, missed) = (
            _growths(scenes, fields_of(scenes, solutions, grid=grid), tolerance=tolerance)
            for grid in (0, 1)
        )
    change = np.abs(growth - before)
    # A derivative may agree by chance, or be small because its parts cancel; not all do.
    change = np.maximum(change, SHARE_OF_OTHERS * change.max(axis=0))
    rules = [remainder(*each, tolerance=tolerance) for each in zip(scenes, solutions, strict=True)]
    factor, left = np.array(rules).T
    # What the iteration left of the pressure is left of its shares in a derivative.
    size = [np.abs(solution.states[-1].unknowns[0]).max() for solution in solutions]
    relative = left / np.maximum(size, np.finfo(float).tiny)
    error = np.where(growth != 0, factor * change, 0.0) + missed + relative * np.abs(growth)
    return [_record(scene, growth[:, k], error[:, k]) for k, scene in enumerate(scenes)]


def _growths(
    scenes: Sequence[Scene], films: Fields, *, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """The mean forces' growth with each number times its unit (``_unit``), by one grid.

    Returns:
        The growths in newtons and what the adjoint's iteration and differences may leave of them,
        each of shape (numbers, scenes).
    """
    left = np.maximum(ADJOINT_SHARE * tolerance * films.problems.numbers["epsilon"], LEAST_LEFT)
    sensitive = sensitivity(films, tolerance=left)
    overpressure = films.mean(films.overpressure)
    scale = np.array([scene.force_scale_n for scene in scenes])
    growth, missed = np.zeros((2, len(DERIVATIVES), len(scenes)))
    folded = {"x_m": films.grid.fold_x, "y_m": films.grid.fold_y}
    for k, number in enumerate(DERIVATIVES):
        if folded.get(number):
            continue  # the force is even in the place
        ahead, behind = (
            [moved(scene, number, sign * STEP * _unit(scene, number)) for scene in scenes]
            for sign in (1, -1)
        )
        if all(_equation(a) == _equation(b) for a, b in zip(ahead, behind, strict=True)):
            continue
        source = (_residual_of(behind, films) - _residual_of(ahead, films)) / (2 * STEP)
        parts = films.on_all_nodes(sensitive * source) * films.plain_weights
        wider = [b.force_scale_n - a.force_scale_n for a, b in zip(behind, ahead, strict=True)]
        growth[k] = scale * parts.sum(axis=(1, 2, 3)) + np.array(wider) / (2 * STEP) * overpressure
        missed[k] = (STEP_MISSES + left) * scale * np.abs(parts).sum(axis=(1, 2, 3))
    return growth, missed


def _equation(scene: Scene) -> object:
    """All that a scene's dimensionless equation depends on."""
    scenes = Scenes.of([scene])
    return numbers_table(scenes, terms_of(scene)).tobytes(), scenes.places[0]


def _residual_of(scenes: Sequence[Scene], films: Fields) -> np.ndarray:
    """The residual of other scenes at the pressure of these."""
    problems = problems_of(scenes, films.grid)
    return residual(Fields(problems, films.grid, films.overpressure[films.inner]))


def _record(scene: Scene, growth: np.ndarray, error: np.ndarray) -> Derivatives:
    """A scene's derivatives, those to its place turned into the actuator's axes."""
    if not np.isfinite(error).all():
        return Derivatives(status=NOT_FOUND)
    units, pad = [_unit(scene, number) for number in DERIVATIVES], scene.pad
    values, errors = (
        dict(zip(DERIVATIVES, (each / units).tolist(), strict=True)) for each in (growth, error)
    )
    values["x_m"], values["y_m"] = pad.turned(values["x_m"], values["y_m"])
    from_x, from_y = pad.turned(errors["x_m"], 0.0), pad.turned(0.0, errors["y_m"])
    errors["x_m"], errors["y_m"] = (abs(a) + abs(b) for a, b in zip(from_x, from_y, strict=True))
    return Derivatives(value=values, error=errors, status="ok")


def residual(films: Fields) -> np.ndarray:
    """Return the residual of the film equation at the unknowns.

    The residual is ∇·(W H³ρ ∇P) − σ ∂(Hρ)/∂T − Λ ∂(Hρ)/∂X, W the flow over a viscous gas',
    of shape (scenes, nx, ny, nt).
    """
    flow = films.divergence(films.slope * (films.mobility * films.mass))
    moved = films.sigma * films.area * films.t_derivative(films.mass)
    moved += films.numbers("bearing", absent=0.0) * films.slide(films.mass)
    return np.asarray((flow - moved)[films.inner])


def moved(scene: Scene, number: str, by: float) -> Scene:
    """The scene with another number; ``x_m`` and ``y_m`` are along the pad's own axes."""
    if number in ("x_m", "y_m"):
        x_m, y_m = scene.pad.turned(*((by, 0.0) if number == "x_m" else (0.0, by)))
        return replace(scene, x_m=scene.x_m + x_m, y_m=scene.y_m + y_m)
    if number in ("h0_m", "hv_m"):
        return replace(scene, **{number: getattr(scene, number) + by})
    return scene.with_gas(**{number: getattr(scene.gas, number) + by})


def _unit(scene: Scene, number: str) -> float:
    """Return the scale of a number: itself, or the gap or the length that it goes with."""
    if number in ("h0_m", "hv_m"):
        return scene.h0_m
    if number in ("x_m", "y_m"):
        return scene.pad.length_x_m
    return float(getattr(scene.gas, number))
