"""Forces of scenes with errors, each by the cheapest method that meets the tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from squeezefilm.errors import apply_with_bisection, unexpected_error_status
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.film.validity import validity_texts
from squeezefilm.reynolds.asymptotics.composite import (
    EMPTY_EXPANSION_RESULTS,
    ExpansionResults,
    composite_forces,
    reasons_not_expanded,
)
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.periodic.refinement import solve_periodic
from squeezefilm.reynolds.periodic.resolution import unresolved_profile_reasons
from squeezefilm.reynolds.plan import SolvePlan, solve_plan_of
from squeezefilm.reynolds.terms import unsupported_on_grid_reason
from squeezefilm.solution import Solution, Solutions

METHODS = ("auto", "composite", "periodic")


def solve(
    scenes: Scenes | Sequence[Scene],
    *,
    tolerance: float,
    method: str = "auto",
    device: Device | None = None,
    keep_states: bool = False,
    report: Callable[[int], object] = lambda solved: None,
) -> Solutions:
    """Mean forces of scenes: |error| ≤ tolerance · |force| + round-off floor, or a reason why not.

    What of a scene's gas is ``auto`` must be decided (quantities/model_error.py).

    Each scene is solved by itself: its result does not depend on the others, and an unexpected
    error in one, which becomes its status, does not touch theirs.

    Args:
        tolerance: relative error asked for.
        method: one of METHODS. ``auto`` takes the composite expansion where layers are thin and it
            holds the tolerance, else the periodic state. ``composite`` always gives
            its force; the status then says where its estimate is above the tolerance.
        device: an OpenCL device; the default one if not given.
        keep_states: whether solutions by the periodic method have their states on the last two
            grids: a quantity is a function of them, and its change between the two its error.
        report: called with the number of scenes that were finished, as they are; with a negative
            number for those that an unexpected error asks to be solved again.
    """

    if not len(scenes):
        return Solutions.of([])
    scenes = Scenes.of(scenes)
    if any(["auto" in (film.gas.inertia, film.gas.thermal) for film in scenes.films]):
        raise ValueError("what of a scene's gas is auto must be decided before it is solved")

    def solve_subset(subset: Scenes) -> Solutions:
        finished = 0

        def count_progress(more: int) -> None:
            nonlocal finished
            finished += more
            report(more)

        plan, validity = solve_plan_of(subset), validity_texts(subset)
        solutions, _ = known_solutions(plan, tolerance=tolerance, method=method)
        solutions.validity[:] = validity
        waiting = int(np.count_nonzero(solutions.status == ""))
        if not waiting:
            count_progress(len(subset))
            return solutions
        chosen = device or choose_device()
        if not chosen.is_cpu:
            from squeezefilm.reynolds.self_test import check_device

            check_device(chosen)
        count_progress(len(subset) - waiting)
        how: dict[str, Any] = {
            "device": chosen,
            "keep_states": keep_states,
            "report": count_progress,
        }
        try:
            solve_periodic(plan, solutions, tolerance=tolerance, **how)
        except Exception:
            chosen.queue.finish()  # kernels under way write into arrays that this sets free
            report(-finished)
            raise
        return solutions

    def solution_of_error(error: Exception) -> Solution:
        report(1)
        return Solution(status=unexpected_error_status(error), method=method)

    return Solutions.of(apply_with_bisection(solve_subset, scenes, failed=solution_of_error))


def known_solutions(
    plan: SolvePlan, *, tolerance: float, method: str
) -> tuple[Solutions, ExpansionResults]:
    """The solutions as far as they are known before a periodic state is solved for.

    The status is empty where one will be. The results behind those by an expansion go with them.
    """
    refused = unresolved_profile_reasons(plan, tolerance=tolerance)
    found = EMPTY_EXPANSION_RESULTS
    if method != "periodic":
        found = composite_forces(plan, tolerance=tolerance, auto=method == "auto", excluded=refused)
    if method == "composite":
        refused = reasons_not_expanded(plan) | refused
    else:
        refused = (
            plan.compute_cached("on grids", plan.reasons_by_row, unsupported_on_grid_reason)
            | refused
        )
    solutions = Solutions.unsolved_of_method(
        "periodic" if method == "auto" else method, len(plan.scenes)
    )
    for row, reason in refused.items():
        solutions.status[row] = reason
    if rows := found.scene_rows.tolist():
        solutions.status[rows], solutions.method[rows] = found.statuses(tolerance), "composite"
        solutions.domain[rows], solutions.absent_terms[rows] = "whole", plan.absent_terms[rows]
        solutions.nx[rows], solutions.ny[rows] = found.nx, found.ny
        solutions.operation_count[rows] = found.flops
        scale_n = np.where(
            np.isfinite(found.pressure_ratio_error),
            plan.scenes[found.scene_rows].force_scale_n,
            np.nan,
        )
        solutions.force_n[rows] = found.mean_pressure_ratio * scale_n
        solutions.force_error_n[rows] = found.pressure_ratio_error * scale_n
    return solutions, found
