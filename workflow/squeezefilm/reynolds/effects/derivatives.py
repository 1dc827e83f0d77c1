"""Derivatives of the mean force to gap, amplitude, position and the gas' numbers: one adjoint.

With the film's residual R(P, θ) = 0 of an unknown P and a number θ, the mean pressure changes by
⟨λ S⟩ per change of θ, with S = −∂R/∂θ at the film's own P and λ the answer to any source of mass
(sensitivity.py), solved for once and not for each number. S is a difference of residuals: no film
is solved for another θ. All is done on two grids, whose difference tells the error.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from math import isfinite

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.io.solution import DERIVATIVES, Derivatives, Solution
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.effects.automatic import MODEL_TOLERANCE, decided
from squeezefilm.reynolds.effects.fields import Fields
from squeezefilm.reynolds.effects.sensitivity import sensitivity
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import Needs, needs_of
from squeezefilm.reynolds.periodic.launch import Batch, launch
from squeezefilm.reynolds.periodic.resolution import finer_grid, grid_for, unseen_profiles
from squeezefilm.reynolds.periodic.states import STATUS
from squeezefilm.reynolds.problems import numbers_table, problems_of
from squeezefilm.reynolds.terms import Terms, terms_of
from squeezefilm.reynolds.terms.bearing import Bearing
from squeezefilm.reynolds.terms.gap import AnyGap
from squeezefilm.reynolds.terms.polytropic import Polytropic
from squeezefilm.reynolds.terms.rarefaction import Rarefaction

# Terms of the equation that ``residual`` and the adjoint have.
KNOWN = (AnyGap, Bearing, Polytropic, Rarefaction)
# Below this, iterations would end in rounding.
LEAST_TOLERANCE = 1e-8
# Shares of the tolerance that the states and the adjoint may leave, the latter times ε: a source
# of order ε makes a force of its square.
STATE_SHARE, ADJOINT_SHARE, LEAST_LEFT = 1e-3, 1e-4, 1e-12
# The error is so many times the change from grid to grid, each no less than a share of the largest
# among a scene's: without the share 15 of 5156 of 200 random films were off by up to 8 times it.
CHANGE_FACTOR, SHARE_OF_OTHERS = 2.0, 0.3
# The step of a difference of residuals, of a number's unit.
STEP = 3e-5
# What such a difference misses, as a share of the size of its parts: its third order and rounding.
STEP_MISSES = 1e-8
NOT_FOUND = "derivatives not found: GMRES did not solve the adjoint problem"
# Unknowns that the host's Krylov vectors have room for, and of a batch that stays in the caches.
MOST_UNKNOWNS, MOST_TOGETHER = 200_000, 2**15


def with_derivatives(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution],
    *,
    tolerance: float,
    model_tolerance: float = MODEL_TOLERANCE,
    method: str = "auto",
    device: Device | None = None,
) -> list[Solution]:
    """The scenes' forces, as ``solve`` gave them with the same arguments, with derivatives.

    They are those of the periodic state, by whichever method its force was found.
    """
    chosen = device or choose_device()
    tolerance = max(tolerance, LEAST_TOLERANCE)
    scenes = decided(scenes, model_tolerance=model_tolerance, method=method, device=chosen)
    found: dict[int, Derivatives] = {}
    groups: dict[tuple[Terms, tuple[Grid, Grid], float], list[int]] = defaultdict(list)
    for index, (scene, solution) in enumerate(zip(scenes, solutions, strict=True)):
        needs = needs_of(scene)
        grids = _grids(scene, needs, tolerance=tolerance)
        if not isfinite(solution.force_n):
            found[index] = Derivatives(status="no force")
        elif isinstance(grids, str):
            found[index] = Derivatives(status=grids)
        else:
            groups[needs.terms, grids, scene.aspect].append(index)
    for (_, grids, _), group in groups.items():
        step = max(1, MOST_TOGETHER // grids[1].count)
        for start in range(0, len(group), step):
            some = group[start : start + step]
            theirs = [scenes[index] for index in some]
            batch = _derivatives(theirs, grids, tolerance=tolerance, device=chosen)
            found |= dict(zip(some, batch, strict=True))
    return [replace(solution, derivatives=found[index]) for index, solution in enumerate(solutions)]


def _grids(scene: Scene, needs: Needs, *, tolerance: float) -> tuple[Grid, Grid] | str:
    """The two grids of a scene, or why it has no derivatives."""
    if scene.finger.shape != "rectangle":
        return "derivatives are known of rectangular pads alone"
    if unknown := [term.label for term in needs.terms if not isinstance(term, KNOWN)]:
        return f"derivatives are not known with {unknown[0]}: its adjoint is not"
    if unseen := unseen_profiles(needs, tolerance=tolerance):
        return unseen[0]
    (coarse,) = grid_for(needs, tolerance=tolerance)
    fine = finer_grid(coarse)
    if fine is None or fine.count > MOST_UNKNOWNS:
        return f"derivatives to {tolerance:g} want more than {MOST_UNKNOWNS} unknowns"
    return coarse, fine


def _derivatives(
    scenes: Sequence[Scene], grids: tuple[Grid, Grid], *, tolerance: float, device: Device
) -> list[Derivatives]:
    """Derivatives of scenes of like terms, by two grids."""
    problems = [problems_of(scenes, grid, tolerance=STATE_SHARE * tolerance) for grid in grids]
    batch = Batch(Scenes.of(scenes), problems[0].terms, grids, [STATE_SHARE * tolerance] * 2)
    (states,) = launch([batch], device=device).states()
    with np.errstate(all="ignore"):
        (before, _), (growth, rounded) = (
            _growths(scenes, Fields(each, grid, state.overpressure), tolerance=tolerance)
            for each, grid, state in zip(problems, grids, states, strict=True)
        )
    change = np.abs(growth - before)
    # A derivative may agree by chance, or be small because its parts cancel; not all do.
    change = np.maximum(change, SHARE_OF_OTHERS * change.max(axis=0))
    error = np.where(growth != 0, CHANGE_FACTOR * change, 0.0) + rounded
    endings = zip(*([STATUS[each] for each in state.status] for state in states), strict=True)
    return [
        _record(scene, growth[:, k], error[:, k], status=next(filter(_failed, ending), "ok"))
        for k, (scene, ending) in enumerate(zip(scenes, endings, strict=True))
    ]


def _growths(
    scenes: Sequence[Scene], films: Fields, *, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """The mean forces' growth with each number times its unit (``_unit``), by one grid.

    Returns:
        The growths in newtons and what iterations and differences may leave of them, each of shape
        (numbers, scenes).
    """
    left = np.maximum(ADJOINT_SHARE * tolerance * films.problems.epsilon, LEAST_LEFT)
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
        parts = films.with_rim(sensitive * source)
        wider = [b.force_scale_n - a.force_scale_n for a, b in zip(behind, ahead, strict=True)]
        growth[k] = scale * films.mean(parts) + np.array(wider) / (2 * STEP) * overpressure
        missed[k] = (STEP_MISSES + left) * scale * films.mean(np.abs(parts))
        missed[k] += STATE_SHARE * tolerance * np.abs(growth[k])
    return growth, missed


def _equation(scene: Scene) -> object:
    """All that a scene's dimensionless equation depends on."""
    return numbers_table(Scenes.of([scene]), terms_of(scene)).tobytes(), scene.place


def _residual_of(scenes: Sequence[Scene], films: Fields) -> np.ndarray:
    """The residual of other scenes at the pressure of these."""
    problems = problems_of(scenes, films.grid, tolerance=films.problems.tolerance)
    return residual(Fields(problems, films.grid, films.overpressure[films.inner]))


def _failed(ending: str) -> bool:
    return ending != "ok"


def _record(scene: Scene, growth: np.ndarray, error: np.ndarray, *, status: str) -> Derivatives:
    """A scene's derivatives, those to its place turned into the actuator's axes."""
    if status != "ok":
        return Derivatives(status=status)
    if not np.isfinite(error).all():
        return Derivatives(status=NOT_FOUND)
    units = [_unit(scene, number) for number in DERIVATIVES]
    values = dict(zip(DERIVATIVES, (growth / units).tolist(), strict=True))
    errors = dict(zip(DERIVATIVES, (error / units).tolist(), strict=True))
    finger = scene.finger
    values["x_m"], values["y_m"] = finger.turned(values["x_m"], values["y_m"])
    from_x, from_y = finger.turned(errors["x_m"], 0.0), finger.turned(0.0, errors["y_m"])
    errors["x_m"], errors["y_m"] = (abs(a) + abs(b) for a, b in zip(from_x, from_y, strict=True))
    return Derivatives(value=values, error=errors, status="ok")


def residual(films: Fields) -> np.ndarray:
    """What is left of the film equation, Σ c_k ∇·(H^(3−k) ρ^(1−k) ∇P) − σ ∂(Hρ)/∂T − Λ ∂(Hρ)/∂X.

    At the unknowns, shape (scenes, nx, ny, nt).
    """
    flux = films.slope.times(films.ease * films.mass)
    left = films.divergence(flux) - films.sigma * films.t_derivative(films.mass)
    speed = films.numbers("bearing", absent=0.0)
    if np.any(speed):
        left = left - speed * films.x_derivative(films.mass)
    return np.asarray(left[films.inner])


def moved(scene: Scene, number: str, by: float) -> Scene:
    """The scene with another number; ``x_m`` and ``y_m`` are along the finger's own axes."""
    if number in ("x_m", "y_m"):
        x_m, y_m = scene.finger.turned(*((by, 0.0) if number == "x_m" else (0.0, by)))
        return replace(scene, x_m=scene.x_m + x_m, y_m=scene.y_m + y_m)
    if number in ("h0_m", "hv_m"):
        return replace(scene, **{number: getattr(scene, number) + by})
    return replace(scene, gas=replace(scene.gas, **{number: getattr(scene.gas, number) + by}))


def _unit(scene: Scene, number: str) -> float:
    """What a number is measured by: itself, or the gap or the length that it goes with."""
    if number in ("h0_m", "hv_m"):
        return scene.h0_m
    if number in ("x_m", "y_m"):
        return scene.finger.length_x_m
    return float(getattr(scene.gas, number))
