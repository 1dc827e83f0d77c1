"""From scenes to forces with errors, each by the cheapest method that holds the tolerance."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import TypeVar

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import validity
from squeezefilm.io.errors import InputError
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.limits import forces as limits
from squeezefilm.reynolds.limits.domain import unknown_to
from squeezefilm.reynolds.limits.films import films_of, limit_axis
from squeezefilm.reynolds.limits.forces import LimitForces, limit_points
from squeezefilm.reynolds.needs import LeftOut, Needs, needs_of
from squeezefilm.reynolds.periodic.refinement import solve_periodic
from squeezefilm.reynolds.periodic.resolution import nodes_for_profile, unseen_profile
from squeezefilm.reynolds.self_test import check_device
from squeezefilm.reynolds.solution import solution_of
from squeezefilm.reynolds.terms import first_reason, terms_of

# The methods from cheap to dear; the limits know their own error before anything is solved.
LIMITS = ("closed-form", "fast-limit", "boundary-layer", "small-amplitude", "matched-limit")
METHODS = ("auto", *LIMITS, "periodic")
# The fast limit is not worth choosing: its error estimate needs the boundary layer's correction.
CHOSEN_LIMITS = tuple(name for name in LIMITS if name != "fast-limit")
# Below this the matched limit's grid makes it as dear as a periodic state. Without inertia it is so
# anywhere: of 64 films in a call it took 80 to 2200 µs each, the state 44 to 1850 (σ 10 to 1e6).
MATCHED_LEAST_TOLERANCE = 5e-4
# Scenes whose fields are held at a time; more would fall out of the caches.
LIMIT_BATCH = 256
# Which squeeze number a limit's grid must resolve layers of, if any.
RESOLVES_LAYERS = {"small-amplitude", "matched-limit"}

Result = TypeVar("Result")


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
    def relative_error(self) -> float:
        """The error over the mean; 0 for a film that is at rest and bears nothing."""
        if self.error == 0:
            return 0.0
        return self.error / abs(self.mean) if self.mean else inf

    @property
    def left_out(self) -> LeftOut:
        return LeftOut("time", f"the {self.method} is good to {self.relative_error:.1e}")

    def holds(self, tolerance: float) -> bool:
        """Whether the estimate meets a relative tolerance; ``nan`` does not."""
        return self.error <= tolerance * abs(self.mean)

    def status(self, tolerance: float) -> str:
        """``ok``, or what is wrong with the estimate."""
        if not isfinite(self.error):
            return f"{self.method} says nothing of its error here"
        if not self.holds(tolerance):
            return f"{self.method} is good to {self.relative_error:.1e} only"
        return "ok"


@dataclass(frozen=True)
class Way:
    """How a scene is treated, decided before anything is solved: ``explain`` shows it.

    Attributes:
        method: by which its force is computed, or would be.
        limit: the force by a limit; None where the full equation is solved.
        refused: why there will be no force; empty where it is tried.
    """

    method: str
    limit: LimitResult | None = None
    refused: str = ""


ON_GRID = Way("periodic")


def solve(
    scenes: Sequence[Scene],
    *,
    tolerance: float,
    method: str = "auto",
    device: Device | None = None,
    keep_states: bool = False,
    report: Callable[[int], object] = lambda solved: None,
) -> list[Solution]:
    """Mean forces of scenes: |error| ≤ tolerance · |force| + round-off floor, or a reason why not.

    What of a scene's gas is ``auto`` must be decided (quantities/model_error.py).

    Each scene is solved by itself: its result does not depend on the others, and an unexpected
    error in one, which becomes its status, does not touch theirs.

    Args:
        tolerance: relative error asked for.
        method: one of METHODS. ``auto`` takes the first limit whose error estimate holds the
            tolerance, of those that may by their order, else the periodic state. A limit asked
            for by name always gives its force; the status then says where its estimate is above
            the tolerance.
        device: an OpenCL device; the default one if left out.
        keep_states: whether solutions by the periodic method have their states on the last two
            grids: a quantity is a function of them, and its change between the two its error.
        report: called with the number of scenes that were finished, as they are; with a negative
            number for those that an unexpected error asks to be solved again.
    """

    if any("auto" in (scene.gas.inertia, scene.gas.heat) for scene in scenes):
        raise ValueError("what of a scene's gas is auto must be decided before it is solved")

    def attempt(some: Sequence[Scene]) -> list[Solution]:
        finished = 0

        def count(more: int) -> None:
            nonlocal finished
            finished += more
            report(more)

        try:
            solutions = _solve(
                some,
                tolerance=tolerance,
                method=method,
                device=device,
                keep_states=keep_states,
                report=count,
            )
            for scene, solution in zip(some, solutions, strict=True):
                solution.validity = validity(scene)
            return solutions
        except Exception:
            report(-finished)
            raise

    def failed(error: Exception) -> Solution:
        report(1)
        return Solution(status=unexpected(error), method=method)

    return each_on_its_own(attempt, scenes, failed=failed)


def each_on_its_own(
    work: Callable[[Sequence[Scene]], list[Result]],
    scenes: Sequence[Scene],
    *,
    failed: Callable[[Exception], Result],
) -> list[Result]:
    """``work`` on all scenes; where it ends in an unexpected error, that of one scene alone.

    Raises:
        InputError: that of ``work``, such as a device that is not there: it concerns all scenes.
    """
    try:
        return work(scenes)
    except InputError:
        raise
    except Exception as error:
        if len(scenes) == 1:
            return [failed(error)]
    half = len(scenes) // 2
    halves = (scenes[:half], scenes[half:])
    return [result for some in halves for result in each_on_its_own(work, some, failed=failed)]


def unexpected(error: Exception) -> str:
    """The status of a scene that ended in an error which no method foresees."""
    return " ".join(f"unexpected error: {type(error).__name__}: {error}".split())


def _solve(
    scenes: Sequence[Scene],
    *,
    tolerance: float,
    method: str,
    device: Device | None,
    keep_states: bool,
    report: Callable[[int], object],
) -> list[Solution]:
    needs = [needs_of(scene) for scene in scenes]
    solutions: dict[int, Solution] = {}
    group: list[int] = []
    ways = ways_of(scenes, needs, tolerance=tolerance, method=method)
    for index, way in enumerate(ways):
        if way.refused:
            solutions[index] = Solution(status=way.refused, method=way.method)
        elif way.limit is not None:
            limit = way.limit
            solutions[index] = _limit_solution(scenes[index], needs[index], limit, tolerance)
        else:
            group.append(index)
    report(len(solutions))
    if group:
        some, theirs = [scenes[index] for index in group], [needs[index] for index in group]
        chosen = device or choose_device()
        if not chosen.processor:
            check_device(chosen)
        try:
            rest = solve_periodic(
                some,
                theirs,
                tolerance=tolerance,
                device=chosen,
                keep_states=keep_states,
                report=report,
            )
        except Exception:
            chosen.queue.finish()  # kernels under way write into arrays that this sets free
            raise
        solutions.update(zip(group, rest, strict=True))
    return [solutions[index] for index in range(len(scenes))]


def ways_of(
    scenes: Sequence[Scene], needs: Sequence[Needs], *, tolerance: float, method: str
) -> list[Way]:
    """How ``solve`` treats each scene, as far as that is decided before solving."""
    unseen = [unseen_profile(need, tolerance=tolerance) for need in needs]
    seen = [index for index, reason in enumerate(unseen) if reason is None]
    found = by_limits(
        [scenes[index] for index in seen],
        [needs[index] for index in seen],
        tolerance=tolerance,
        method=method,
    )
    limit_results = {seen[place]: result for place, result in found.items()}
    return [
        Way("periodic" if method == "auto" else method, refused=reason)
        if reason
        else _way(scene, need, limit_results.get(index), method=method)
        for index, (scene, need, reason) in enumerate(zip(scenes, needs, unseen, strict=True))
    ]


def _way(scene: Scene, needs: Needs, limit: LimitResult | None, *, method: str) -> Way:
    if limit is not None:
        return Way(limit.method, limit=limit)
    if method in LIMITS:
        return Way(method, refused=unknown_to(method, scene, needs))
    refused = first_reason(term.refused_on_grid(scene) for term in needs.terms)
    return Way("periodic", refused=refused) if refused else ON_GRID


def by_limits(
    scenes: Sequence[Scene], needs: Sequence[Needs], *, tolerance: float, method: str
) -> dict[int, LimitResult]:
    """The scenes that a limit solves, by index: to the tolerance if ``auto``, else at any error."""
    if method == "periodic":
        return {}
    results: dict[int, LimitResult] = {}
    # A limit's promise, an inequality, is asked first: it is cheap and mostly not given.
    for name in CHOSEN_LIMITS if method == "auto" else (method,):
        waiting = [
            index
            for index, (scene, need) in enumerate(zip(scenes, needs, strict=True))
            if index not in results
            and (method != "auto" or _promises(name, scene, need, tolerance))
            and not unknown_to(name, scene, need)
        ]
        for index, result in _evaluate(name, scenes, needs, waiting, tolerance=tolerance).items():
            if method != "auto" or result.holds(tolerance):
                results[index] = result
    return results


def _promises(name: str, scene: Scene, needs: Needs, tolerance: float) -> bool:
    """Whether the limit may hold the tolerance and is worth its cost.

    The orders are those of the error estimates. Their factors are about the smallest that 2400
    random films had (ε 0.01–0.98, σ 0.1–1e6, sides 1:10 to 10:1), of the paper's sinc and of a
    piston. A profile between the two may be sent on although a limit would do.
    """
    if name == "matched-limit" and (
        tolerance < MATCHED_LEAST_TOLERANCE or scene.gas.inertia != "included"
    ):
        return False
    match name:
        case "closed-form":
            order = 0.3 * scene.sigma**-0.5
        case "boundary-layer":
            even = needs.uniform and scene.finger.gap.flat
            order = (0.3 if even else 100) * scene.sigma**-1.5
        case "small-amplitude":
            order = scene.epsilon**2
        case "matched-limit":
            order = (3 if needs.uniform else 15) * scene.epsilon**2 * scene.sigma**-1.5
        case _:
            raise ValueError(f"no limit is called {name}")
    return order <= tolerance


def _evaluate(
    name: str,
    scenes: Sequence[Scene],
    needs: Sequence[Needs],
    which: Sequence[int],
    *,
    tolerance: float,
) -> dict[int, LimitResult]:
    """One limit on some of the scenes, those with one grid together."""
    groups: dict[tuple[int, int, bool, bool], list[int]] = defaultdict(list)
    for index in which:
        scene = scenes[index]
        layers = scene.sigma if name in RESOLVES_LAYERS else 1.0
        seen_x, seen_y = nodes_for_profile(needs[index], tolerance=tolerance)
        # The error estimate wants every other node to see the profile.
        groups[
            max(limit_points(tolerance=tolerance, sigma=layers), 2 * seen_x + 1),
            max(limit_points(tolerance=tolerance, sigma=layers * scene.aspect**2), 2 * seen_y + 1),
            scene.actuator.profile.is_complex,
            scene.finger.gap.flat,
        ].append(index)
    results = {}
    for (nx, ny, *_), group in groups.items():
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
    numbers: dict[str, np.ndarray] = _numbers_of_terms(scenes)
    if not scenes[0].finger.gap.flat:
        numbers["rest"] = np.stack([scene.rest_gap(x, y) for scene in scenes])
    amplitude = np.stack([places[scene.place] for scene in scenes])
    return function(films_of(epsilon, sigma, amplitude, aspect=aspect, **numbers))


def _numbers_of_terms(scenes: Sequence[Scene]) -> dict[str, np.ndarray]:
    """What the terms of some scenes say to a limit; 0 for a scene without the term."""
    each = [
        {
            name: value
            for term in terms_of(scene)
            for name, value in term.limit_numbers(scene).items()
        }
        for scene in scenes
    ]
    names = dict.fromkeys(name for numbers in each for name in numbers)
    return {name: np.array([numbers.get(name, 0.0) for numbers in each]) for name in names}


def _limit_solution(scene: Scene, needs: Needs, result: LimitResult, tolerance: float) -> Solution:
    finite = isfinite(result.error)
    return solution_of(
        scene,
        mean=result.mean if finite else np.nan,
        error=result.error if finite else np.nan,
        left_out=(result.left_out, *needs.terms_left_out),
        status=result.status(tolerance),
        method=result.method,
        nx=result.nx,
        ny=result.ny,
        work=result.flops,
    )
