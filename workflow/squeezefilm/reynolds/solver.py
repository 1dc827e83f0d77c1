"""From scenes to forces with errors, each by the cheapest method that holds the tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite, nan
from typing import Any

import numpy as np

from squeezefilm.errors import each_on_its_own, unexpected
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.film.validity import validities
from squeezefilm.reynolds.asymptotics.composite import Expanded
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.needs import Needs, needs_of
from squeezefilm.reynolds.periodic.refinement import solve_periodic
from squeezefilm.reynolds.plan import plans_of
from squeezefilm.reynolds.self_test import check_device
from squeezefilm.reynolds.terms import left_out_of
from squeezefilm.solution import Solution, Solutions


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
        method: one of METHODS. ``auto`` takes the composite expansion where that holds the
            tolerance and should cost less, else the periodic state. ``composite`` always gives
            its force; the status then says where its estimate is above the tolerance.
        device: an OpenCL device; the default one if left out.
        keep_states: whether solutions by the periodic method have their states on the last two
            grids: a quantity is a function of them, and its change between the two its error.
        report: called with the number of scenes that were finished, as they are; with a negative
            number for those that an unexpected error asks to be solved again.
    """

    if not len(scenes):
        return Solutions.of([])
    scenes = Scenes.of(scenes)
    if any("auto" in (film.gas.inertia, film.gas.heat) for film in scenes.films):
        raise ValueError("what of a scene's gas is auto must be decided before it is solved")

    def attempt(some: Scenes) -> Solutions:
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
            solutions.validity[:] = validities(some)
            return solutions
        except Exception:
            report(-finished)
            raise

    def failed(error: Exception) -> Solution:
        report(1)
        return Solution(status=unexpected(error), method=method)

    return Solutions.of(each_on_its_own(attempt, scenes, failed=failed))


def _solve(
    scenes: Scenes,
    *,
    tolerance: float,
    method: str,
    device: Device | None,
    keep_states: bool,
    report: Callable[[int], object],
) -> Solutions:
    needs = needs_of(scenes)
    plans = plans_of(needs, tolerance=tolerance, method=method)
    report(len(plans))
    how: dict[str, Any] = {"device": device, "keep_states": keep_states, "report": report}
    if not plans:
        return _periodic(needs, tolerance=tolerance, **how)
    solutions = Solutions.of_method(method, len(scenes))
    for row, plan in plans.items():
        solutions.status[row], solutions.method[row] = plan.refused, plan.method
        if plan.expanded is not None:
            _put_expanded(solutions, row, plan.expanded, needs, tolerance=tolerance)
    rest = np.delete(np.arange(len(scenes)), list(plans))
    if rest.size:
        solutions.put(rest, _periodic(needs[rest], tolerance=tolerance, **how))
    return solutions


def _periodic(needs: Needs, *, device: Device | None, **how: Any) -> Solutions:
    chosen = device or choose_device()
    if not chosen.processor:
        check_device(chosen)
    try:
        return solve_periodic(needs, device=chosen, **how)
    except Exception:
        chosen.queue.finish()  # kernels under way write into arrays that this sets free
        raise


def _put_expanded(
    solutions: Solutions, row: int, found: Expanded, needs: Needs, *, tolerance: float
) -> None:
    """Write the solution of a scene by an expansion."""
    known = isfinite(found.error)
    scale_n = float(np.broadcast_to(needs.scenes.force_scale_n, len(needs))[row])
    neglected = found.left_out, *left_out_of(needs.kinds[needs.kind[row]])
    solutions.force_n[row] = found.mean * scale_n if known else nan
    solutions.force_error_n[row] = found.error * scale_n if known else nan
    solutions.left_out[row] = "; ".join(part.what for part in neglected)
    solutions.status[row] = found.status(tolerance)
    solutions.nx[row], solutions.ny[row] = found.nx, found.ny
    solutions.work[row] = found.flops
