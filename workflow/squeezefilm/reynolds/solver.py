"""From scenes to forces with errors, each by the cheapest method that holds the tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite, nan

from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import validity
from squeezefilm.io.errors import each_on_its_own, unexpected
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.asymptotics.scenes import Expanded
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.effects.automatic import MODEL_TOLERANCE, decided
from squeezefilm.reynolds.needs import Needs, needs_of
from squeezefilm.reynolds.periodic.refinement import solve_periodic
from squeezefilm.reynolds.plan import plans_of
from squeezefilm.reynolds.self_test import check_device
from squeezefilm.reynolds.solution import solution_of


def solve(
    scenes: Sequence[Scene],
    *,
    tolerance: float,
    model_tolerance: float = MODEL_TOLERANCE,
    method: str = "auto",
    device: Device | None = None,
    keep_states: bool = False,
    report: Callable[[int], object] = lambda solved: None,
) -> list[Solution]:
    """Mean forces of scenes: |error| ≤ tolerance · |force| + round-off floor, or a reason why not.

    Each scene is solved by itself: its result does not depend on the others, and an unexpected
    error in one, which becomes its status, does not touch theirs.

    Args:
        tolerance: relative error asked for.
        model_tolerance: change of a force, relative, from which on a term that is ``auto`` in a
            scene is included.
        method: one of METHODS. ``auto`` takes the composite expansion where that holds the
            tolerance and should cost less, else the periodic state. ``composite`` always gives
            its force; the status then says where its estimate is above the tolerance.
        device: an OpenCL device; the default one if left out.
        keep_states: whether solutions by the periodic method have their states on the last two
            grids: a quantity is a function of them, and its change between the two its error.
        report: called with the number of scenes that were finished, as they are; with a negative
            number for those that an unexpected error asks to be solved again.
    """

    def attempt(some: Sequence[Scene]) -> list[Solution]:
        finished = 0

        def count(more: int) -> None:
            nonlocal finished
            finished += more
            report(more)

        try:
            chosen = decided(some, model_tolerance=model_tolerance, method=method, device=device)
            solutions = _solve(
                chosen,
                tolerance=tolerance,
                method=method,
                device=device,
                keep_states=keep_states,
                report=count,
            )
            for scene, solution in zip(chosen, solutions, strict=True):
                solution.validity = validity(scene)
            return solutions
        except Exception:
            report(-finished)
            raise

    def failed(error: Exception) -> Solution:
        report(1)
        return Solution(status=unexpected(error), method=method)

    return each_on_its_own(attempt, scenes, failed=failed)


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
    plans = plans_of(scenes, needs, tolerance=tolerance, method=method)
    for index, plan in enumerate(plans):
        if plan.refused:
            solutions[index] = Solution(status=plan.refused, method=plan.method)
        elif plan.expanded is not None:
            solutions[index] = _by_expansion(
                scenes[index], needs[index], plan.expanded, tolerance=tolerance
            )
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


def _by_expansion(scene: Scene, needs: Needs, found: Expanded, *, tolerance: float) -> Solution:
    known = isfinite(found.error)
    return solution_of(
        scene,
        mean=found.mean if known else nan,
        error=found.error if known else nan,
        left_out=(found.left_out, *needs.terms_left_out),
        status=found.status(tolerance),
        method="composite",
        nx=found.nx,
        ny=found.ny,
        work=found.flops,
    )
