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
from math import atan2, degrees, hypot

import numpy as np

from squeezefilm.film.scene import Gas, Scene
from squeezefilm.io.solution import DERIVATIVES, Derivatives, Solution
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.effects.automatic import MODEL_TOLERANCE, decided
from squeezefilm.reynolds.effects.fields import Fields
from squeezefilm.reynolds.effects.sensitivity import sensitivity
from squeezefilm.reynolds.error_estimate import MOMENT_FACTOR, largest_change
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.modes.galerkin import wants_modes
from squeezefilm.reynolds.needs import Needs, needs_of
from squeezefilm.reynolds.periodic.launch import STATUS, Batch, launch
from squeezefilm.reynolds.periodic.refinement import grid_for
from squeezefilm.reynolds.periodic.resolution import finer_grid, unseen_profile
from squeezefilm.reynolds.problems import problems_of
from squeezefilm.reynolds.terms import Terms
from squeezefilm.reynolds.terms.bearing import Bearing
from squeezefilm.reynolds.terms.polytropic import Polytropic
from squeezefilm.reynolds.terms.rarefaction import Rarefaction

# Terms of the equation that ``residual`` and the adjoint have.
KNOWN = (Bearing, Polytropic, Rarefaction)
# Shares of the tolerance that the states and the adjoint may leave.
STATE_SHARE, ADJOINT_SHARE = 1e-3, 1e-2
# Of a number, or of the length that it goes with: the step of a difference of residuals.
STEP = 3e-5
# What such a difference misses, as a share of the size of its parts: its third order and rounding.
STEP_MISSES = 1e-7
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
    scenes = decided(scenes, model_tolerance=model_tolerance, method=method, device=chosen)
    found: dict[int, Derivatives] = {}
    groups: dict[tuple[Terms, Grid, Grid, float], list[int]] = defaultdict(list)
    for index, (scene, solution) in enumerate(zip(scenes, solutions, strict=True)):
        needs = needs_of(scene)
        grids, refused = _grids(scene, needs, tolerance=tolerance)
        if np.isnan(solution.force_n):
            refused = "no force"
        if refused:
            found[index] = Derivatives(status=refused)
        else:
            groups[needs.terms, *grids, scene.aspect].append(index)
    for (_, coarse, fine, _), group in groups.items():
        step = max(1, MOST_TOGETHER // fine.count)
        for start in range(0, len(group), step):
            some = group[start : start + step]
            theirs = _derivatives(
                [scenes[index] for index in some],
                (coarse, fine),
                tolerance=tolerance,
                device=chosen,
            )
            found |= dict(zip(some, theirs, strict=True))
    return [
        replace(solution, derivatives=found[index]) for index, solution in enumerate(solutions)
    ]


def _grids(
    scene: Scene, needs: Needs, *, tolerance: float
) -> tuple[tuple[Grid, Grid] | None, str]:
    """The two grids of a scene, or why it has no derivatives."""
    if wants_modes(scene):
        return None, "derivatives are known for flat rectangular fingers only"
    if unknown := [term.label for term in needs.terms if not isinstance(term, KNOWN)]:
        return None, f"derivatives are not known with {unknown[0]}: its adjoint is not"
    if reason := unseen_profile(needs, scene.finger, tolerance=tolerance):
        return None, reason
    coarse = grid_for(scene, needs, tolerance=tolerance)
    fine = finer_grid(coarse)
    if fine is None or fine.count > MOST_UNKNOWNS:
        return None, (
            f"derivatives to {tolerance:g} want more than {MOST_UNKNOWNS} unknowns, the most that "
            "their adjoint is solved with"
        )
    return (coarse, fine), ""


def _derivatives(
    scenes: Sequence[Scene], grids: tuple[Grid, Grid], *, tolerance: float, device: Device
) -> list[Derivatives]:
    """Derivatives of scenes of like terms, by two grids."""
    problems = [problems_of(scenes, grid, tolerance=STATE_SHARE * tolerance) for grid in grids]
    (states,) = launch([Batch(grids, problems)], device=device).states()
    with np.errstate(all="ignore"):
        coarse, fine = (
            _rates(scenes, Fields(each, grid, state.overpressure), tolerance=tolerance)
            for each, grid, state in zip(problems, grids, states, strict=True)
        )
    change = MOMENT_FACTOR * largest_change(coarse, grids[0], fine, grids[1])
    weights = np.outer(grids[1].x.weights, grids[1].y.weights)
    value = np.einsum("ksxy,xy->ks", fine, weights)
    error = change + STEP_MISSES * np.einsum("ksxy,xy->ks", np.abs(fine), weights)
    return [
        _record(
            scene,
            value[:, k],
            error[:, k],
            [STATUS[state.status[k]] for state in states],
        )
        for k, scene in enumerate(scenes)
    ]


def _rates(scenes: Sequence[Scene], films: Fields, *, tolerance: float) -> np.ndarray:
    """What adds up to the force's change with each number, shape (numbers, scenes, nx, ny).

    In newtons over the number's unit; its mean over the film is the derivative.
    """
    sensitive = sensitivity(films, tolerance=ADJOINT_SHARE * tolerance)
    overpressure = films.pressure[films.inner].mean(axis=-1) - 1
    scale = films.number(np.array([scene.force_scale_n for scene in scenes]))[..., 0]
    rates = np.zeros((len(DERIVATIVES), *overpressure.shape))
    folded = {"x_m": films.grid.fold_x, "y_m": films.grid.fold_y}
    for rate, number in zip(rates, DERIVATIVES, strict=True):
        if folded.get(number):
            continue  # the force is even in the place
        steps = [_step(scene, number) for scene in scenes]
        ahead, behind = (
            [moved(scene, number, sign * step) for scene, step in zip(scenes, steps, strict=True)]
            for sign in (1, -1)
        )
        source = _residual_of(behind, films) - _residual_of(ahead, films)
        growth = np.array(
            [a.force_scale_n - b.force_scale_n for a, b in zip(ahead, behind, strict=True)]
        )
        rate += scale * (sensitive * source).mean(axis=-1)
        rate += films.number(growth)[..., 0] * overpressure
        rate /= 2 * films.number(np.array(steps))[..., 0]
    return rates


def _residual_of(scenes: Sequence[Scene], films: Fields) -> np.ndarray:
    """The residual of other scenes at the pressure of these."""
    problems = problems_of(scenes, films.grid, tolerance=films.problems.tolerance)
    return residual(Fields(problems, films.grid, films.pressure[films.inner] - 1))


def _record(
    scene: Scene, value: np.ndarray, error: np.ndarray, endings: Sequence[str]
) -> Derivatives:
    """A scene's derivatives, those to its place turned into the actuator's axes."""
    if failed := [ending for ending in endings if ending != "ok"]:
        return Derivatives(status=failed[0])
    if not np.isfinite(error).all():
        return Derivatives(status=NOT_FOUND)
    values = dict(zip(DERIVATIVES, value.tolist(), strict=True))
    errors = dict(zip(DERIVATIVES, error.tolist(), strict=True))
    finger = scene.finger
    values["x_m"], values["y_m"] = finger.turned(values["x_m"], values["y_m"])
    from_x, from_y = finger.turned(errors["x_m"], 0.0), finger.turned(0.0, errors["y_m"])
    errors["x_m"], errors["y_m"] = (abs(a) + abs(b) for a, b in zip(from_x, from_y, strict=True))
    return Derivatives(value=values, error=errors, status="ok")


def residual(films: Fields) -> np.ndarray:
    """What is left of the film equation, Σ c_k ∇·(H^(3−k) ρ^(1−k) ∇P) − σ ∂(Hρ)/∂T − Λ ∂(Hρ)/∂X.

    At the unknowns, shape (scenes, nx, ny, nt).
    """
    flux = films.gradient(films.pressure - 1).times(
        films.flux_factor(films.problems.numbers["flow"])
    )
    left = films.divergence(flux) - films.sigma * films.t_derivative(films.mass)
    speed = films.numbers("bearing", absent=0.0)
    if np.any(speed):
        left = left - speed * films.x_derivative(films.mass)
    return np.asarray(left[films.inner])


def moved(scene: Scene, number: str, by: float) -> Scene:
    """The scene with another number; ``x_m`` and ``y_m`` are along the finger's own axes."""
    if number in ("x_m", "y_m"):
        x_m, y_m = scene.finger.turned(*((by, 0.0) if number == "x_m" else (0.0, by)))
        x_m, y_m = scene.x_m + x_m, scene.y_m + y_m
        return replace(scene, phi_r_m=hypot(x_m, y_m), phi_deg=degrees(atan2(y_m, x_m)))
    owner = scene if hasattr(scene, number) else scene.gas
    changed = replace(owner, **{number: getattr(owner, number) + by})
    return changed if owner is scene else replace(scene, gas=changed)


def _step(scene: Scene, number: str) -> float:
    """Of a number, in its own unit."""
    if number in ("h0_m", "hv_m"):
        return STEP * scene.h0_m
    if number in ("x_m", "y_m"):
        return STEP * scene.finger.length_x_m
    return STEP * float(getattr(scene.gas, number))
