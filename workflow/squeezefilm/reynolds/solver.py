"""From scenes to forces with errors, each by the cheapest method that holds the tolerance."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from squeezefilm.reynolds import limits
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.galerkin import solve_in_modes, wants_modes
from squeezefilm.reynolds.limits import LimitForces, limit_axis, limit_points
from squeezefilm.reynolds.marching import solve_marching
from squeezefilm.reynolds.needs import LeftOut, Needs, needs_of
from squeezefilm.reynolds.refinement import solve_periodic
from squeezefilm.reynolds.resolution import nodes_for_profile, unseen_profile
from squeezefilm.reynolds.solution import Solution, left_out_text, refusal
from squeezefilm.scene import Scene

# The methods from cheap to dear; the limits know their own error before anything is solved.
LIMITS = ("closed-form", "fast-limit", "boundary-layer", "small-amplitude", "matched-limit")
METHODS = ("auto", *LIMITS, "periodic", "march")
# The fast limit is not worth choosing: its error estimate needs the boundary layer's correction.
CHOSEN_LIMITS = tuple(name for name in LIMITS if name != "fast-limit")
# Below this the matched limit's grid makes it as dear as a periodic state.
MATCHED_LEAST_TOLERANCE = 5e-4
# Scenes whose fields are held at a time; more would fall out of the caches.
LIMIT_BATCH = 256
# Which squeeze number a limit's grid must resolve layers of, if any.
RESOLVES_LAYERS = {"small-amplitude", "matched-limit"}


@dataclass(frozen=True)
class LimitResult:
    """A scene's mean overpressure by a limit, its error estimate, and the grid behind it."""

    method: str
    mean: float
    error: float
    nx: int
    ny: int

    @property
    def flops(self) -> float:
        """Floating-point operations, roughly: two fast solves, with their grid error."""
        return 40.0 * self.nx * self.ny * (self.nx + self.ny)

    @property
    def left_out(self) -> LeftOut:
        return LeftOut("time", f"the {self.method} is good to {self.error / abs(self.mean):.1e}")

    def holds(self, tolerance: float) -> bool:
        """Whether the estimate meets a relative tolerance; ``nan`` does not."""
        return self.error <= tolerance * abs(self.mean)


def solve(
    scenes: Sequence[Scene],
    *,
    tolerance: float,
    method: str = "auto",
    device: Device | None = None,
    report: Callable[[int], object] = lambda solved: None,
) -> list[Solution]:
    """Mean forces of scenes: |error| ≤ tolerance · |force| + round-off floor, or a reason why not.

    Each scene is solved by itself: its result does not depend on the others.

    Args:
        tolerance: relative error asked for.
        method: one of METHODS. ``auto`` takes the first limit whose error estimate holds the
            tolerance, of those that may by their order, else the periodic state, on a grid or,
            where that does not know the finger, in its modes (galerkin.py). A limit asked for by
            name always gives its force; the status then says where its estimate is above the
            tolerance.
        device: an OpenCL device; the default one if left out.
        report: called with the number of scenes that were finished, as they are.
    """
    needs = [needs_of(scene) for scene in scenes]
    solutions = _unseen(scenes, needs, tolerance=tolerance, method=method)
    report(len(solutions))
    seen = [index for index in range(len(scenes)) if index not in solutions]
    found = by_limits(
        [scenes[index] for index in seen],
        [needs[index] for index in seen],
        tolerance=tolerance,
        method=method,
    )
    for place, result in found.items():
        index = seen[place]
        solutions[index] = _limit_solution(scenes[index], needs[index], result, tolerance)
        report(1)
    if method in LIMITS:
        for index in set(range(len(scenes))) - set(solutions):
            reason = f"{method} does not know this scene's finger, profile or terms"
            solutions[index] = refusal(reason, method=method)
            report(1)
    left = [index for index in range(len(scenes)) if index not in solutions]
    if method != "march":
        others = [index for index in left if wants_modes(scenes[index])]
        rest = solve_in_modes(
            [scenes[index] for index in others],
            [needs[index] for index in others],
            tolerance=tolerance,
            report=report,
        )
        solutions.update(zip(others, rest, strict=True))
        left = [index for index in left if index not in solutions]
    if left:
        on_device = solve_marching if method == "march" else solve_periodic
        rest = on_device(
            [scenes[index] for index in left],
            [needs[index] for index in left],
            tolerance=tolerance,
            device=device or choose_device(),
            report=report,
        )
        solutions.update(zip(left, rest, strict=True))
    return [solutions[index] for index in range(len(scenes))]


def _unseen(
    scenes: Sequence[Scene], needs: Sequence[Needs], *, tolerance: float, method: str
) -> dict[int, Solution]:
    """Refusals, by index, of scenes whose profile no grid sees."""
    reasons = (
        unseen_profile(need, scene.finger, tolerance=tolerance)
        for scene, need in zip(scenes, needs, strict=True)
    )
    name = "periodic" if method == "auto" else method
    return {i: refusal(reason, method=name) for i, reason in enumerate(reasons) if reason}


def by_limits(
    scenes: Sequence[Scene], needs: Sequence[Needs], *, tolerance: float, method: str
) -> dict[int, LimitResult]:
    """The scenes that a limit solves, by index: to the tolerance if ``auto``, else at any error."""
    if method in ("periodic", "march"):
        return {}
    results: dict[int, LimitResult] = {}
    for name in CHOSEN_LIMITS if method == "auto" else (method,):
        waiting = [
            index
            for index in range(len(scenes))
            if index not in results
            and _applies(name, scenes[index], needs[index])
            and (method != "auto" or _promises(name, scenes[index], needs[index], tolerance))
        ]
        for index, result in _evaluate(name, scenes, needs, waiting, tolerance=tolerance).items():
            if method != "auto" or result.holds(tolerance):
                results[index] = result
    return results


def _applies(name: str, scene: Scene, needs: Needs) -> bool:
    """Whether the limit was derived for this scene's finger and terms at all."""
    if wants_modes(scene):
        return False
    if needs.bearing or needs.polytropic or needs.flow_terms > 2 or scene.epsilon == 0:
        return False
    return name != "closed-form" or (needs.uniform and needs.flow_terms == 1)


def _promises(name: str, scene: Scene, needs: Needs, tolerance: float) -> bool:
    """Whether the limit may hold the tolerance and is worth its cost.

    The orders are those of the error estimates. Their factors are about the smallest that 2400
    random films had (ε 0.01–0.98, σ 0.1–1e6, sides 1:10 to 10:1), of the paper's sinc and of a
    piston. A profile between the two may be sent on although a limit would do.
    """
    if name == "matched-limit" and tolerance < MATCHED_LEAST_TOLERANCE:
        return False
    if name == "matched-limit" and needs.fold_x and needs.fold_y:
        return False  # the periodic state on a quarter costs no more
    order = {
        "closed-form": 0.3 * scene.sigma**-0.5,
        "boundary-layer": (0.3 if needs.uniform else 100) * scene.sigma**-1.5,
        "small-amplitude": scene.epsilon**2,
        "matched-limit": (3 if needs.uniform else 15) * scene.epsilon**2 * scene.sigma**-1.5,
    }
    return order[name] <= tolerance


def _evaluate(
    name: str,
    scenes: Sequence[Scene],
    needs: Sequence[Needs],
    which: Sequence[int],
    *,
    tolerance: float,
) -> dict[int, LimitResult]:
    """One limit on some of the scenes, those with one grid together."""
    groups: dict[tuple[int, int], list[int]] = defaultdict(list)
    for index in which:
        scene = scenes[index]
        layers = scene.sigma if name in RESOLVES_LAYERS else 1.0
        seen_x, seen_y = nodes_for_profile(needs[index], tolerance=tolerance)
        # The error estimate wants every other node to see the profile.
        groups[
            max(limit_points(tolerance=tolerance, sigma=layers), 2 * seen_x + 1),
            max(limit_points(tolerance=tolerance, sigma=layers * scene.aspect**2), 2 * seen_y + 1),
        ].append(index)
    results = {}
    for (nx, ny), group in groups.items():
        for start in range(0, len(group), LIMIT_BATCH):
            some = group[start : start + LIMIT_BATCH]
            forces = _limit(name, [scenes[index] for index in some], nx=nx, ny=ny)
            for index, mean, error in zip(some, forces.mean, forces.error, strict=True):
                results[index] = LimitResult(name, float(mean), float(error), nx, ny)
    return results


def _limit(name: str, scenes: Sequence[Scene], *, nx: int, ny: int) -> LimitForces:
    epsilon = np.array([scene.epsilon for scene in scenes])
    sigma = np.array([scene.sigma for scene in scenes])
    aspect = np.array([scene.aspect for scene in scenes])
    if name == "closed-form":
        return limits.closed_form(epsilon=epsilon, sigma=sigma, aspect=aspect)
    x, y = np.meshgrid(limit_axis(nx).all_nodes, limit_axis(ny).all_nodes, indexing="ij")
    places = {scene.place: scene.amplitude(x, y) for scene in scenes}
    function = {
        "fast-limit": limits.fast_limit,
        "boundary-layer": limits.boundary_layer_limit,
        "small-amplitude": limits.small_amplitude,
        "matched-limit": limits.matched_limit,
    }[name]
    return function(
        epsilon=epsilon,
        sigma=sigma,
        amplitude=np.stack([places[scene.place] for scene in scenes]),
        aspect=aspect,
        slip=np.array([sum(scene.flow_coefficients[1:]) for scene in scenes]),
    )


def _limit_solution(scene: Scene, needs: Needs, result: LimitResult, tolerance: float) -> Solution:
    status = "ok"
    if not np.isfinite(result.error):
        status = f"{result.method} says nothing of its error here"
    elif not result.holds(tolerance):
        status = f"{result.method} is good to {result.error / abs(result.mean):.1e} only"
    finite = np.isfinite(result.error)
    return Solution(
        force_n=result.mean * scene.force_scale_n if finite else np.nan,
        force_error_n=result.error * scene.force_scale_n if finite else np.nan,
        status=status,
        method=result.method,
        left_out=left_out_text((result.left_out, *needs.terms_left_out)),
        nx=result.nx,
        ny=result.ny,
        nt=0,
        newton_steps=0,
        krylov_iterations=0,
        residual=0.0,
        work=result.flops,
    )
