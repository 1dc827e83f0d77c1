"""Forces of scenes with errors, each by the cheapest method that meets the tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite, log10, nan

import numpy as np

from squeezefilm.errors import each_on_its_own, unexpected
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.film.validity import validities
from squeezefilm.reynolds.asymptotics.composite import Expanded, composite, not_derived_for
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.grid import Grid, iteration_flops
from squeezefilm.reynolds.needs import Needs, needs_of
from squeezefilm.reynolds.periodic.refinement import solve_periodic
from squeezefilm.reynolds.periodic.resolution import first_grids, unseen_profiles
from squeezefilm.reynolds.self_test import check_device
from squeezefilm.reynolds.terms import AbsentTerm, Terms, absent_terms, refused_on_grid
from squeezefilm.solution import Solution, Solutions

METHODS = ("auto", "composite", "periodic")
# A scene's force by an expansion, or why it has none.
Plan = Expanded | str


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

    def attempt(some: Scenes) -> Solutions:
        finished = 0

        def count(more: int) -> None:
            nonlocal finished
            finished += more
            report(more)

        try:
            solutions = _solve(some, tolerance, method, device, keep_states, count)
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
    tolerance: float,
    method: str,
    device: Device | None,
    keep_states: bool,
    report: Callable[[int], object],
) -> Solutions:
    needs = needs_of(scenes)
    plans = plans_of(needs, tolerance=tolerance, method=method)
    report(len(plans))
    if len(plans) == len(scenes):
        solutions = Solutions.of_method(method, len(scenes))
    else:
        rest = np.delete(np.arange(len(scenes)), list(plans)) if plans else slice(None)
        chosen = device or choose_device()
        if not chosen.processor:
            check_device(chosen)
        how = {"device": chosen, "keep_states": keep_states, "report": report}
        try:
            solutions = solve_periodic(needs, rest, tolerance=tolerance, **how)  # type: ignore[arg-type]
        except Exception:
            chosen.queue.finish()  # kernels under way write into arrays that this sets free
            raise
    scale_n = np.broadcast_to(scenes.force_scale_n, len(scenes))
    for row, plan in plans.items():
        if isinstance(plan, str):
            solutions.status[row], solutions.method[row] = plan, _named(method)
            continue
        solutions.status[row], solutions.method[row] = plan.status(tolerance), "composite"
        solutions.domain[row], solutions.absent_terms[row] = "whole", needs.absent_terms()[row]
        solutions.nx[row], solutions.ny[row] = plan.nx, plan.ny
        solutions.work[row] = plan.flops
        if isfinite(plan.error):
            solutions.force_n[row] = plan.mean * scale_n[row]
            solutions.force_error_n[row] = plan.error * scale_n[row]
    return solutions


def _named(method: str) -> str:
    """The method of a scene without a force where none was chosen for it."""
    return "periodic" if method == "auto" else method


def plans_of(needs: Needs, *, tolerance: float, method: str) -> dict[int, Plan]:
    """Return the treatment of scenes by ``solve`` that is decided before solving.

    By row, of those that are not solved by the periodic method.
    """
    plans: dict[int, Plan] = {**unseen_profiles(needs, tolerance=tolerance)}
    if method != "periodic":
        plans |= composite(needs, tolerance=tolerance, auto=method == "auto", but=plans)
    if method == "composite":
        return not_derived_for(needs) | plans
    return needs.once("on grids", needs.reasons, refused_on_grid) | plans


@dataclass(frozen=True)
class Preview:
    """One scene's way to its force, unsolved.

    Attributes:
        method: name of the method.
        status: that of the solution as far as it is known before solving: ``ok``, why there will
            be no force, or how far the composite expansion is from the tolerance. What only
            solving shows are a tolerance not reached and Newton's failure.
        domain: part of the pad that is solved, of DOMAINS (needs.py); empty where none is.
        terms: the terms of the equation that are solved.
        nx, ny, nt: points across the pad and over the period, on the finest grid expected.
        absent: the terms that the equation does not have, with the reasons.
        expected_error: relative; the expansion's own estimate, else the tolerance; NaN without a
            force.
        expected_mflop: millions of floating-point operations, to within a factor of about two.
    """

    method: str
    status: str = "ok"
    domain: str = ""
    terms: tuple[str, ...] = ()
    nx: int = 0
    ny: int = 0
    nt: int = 0
    absent: tuple[AbsentTerm, ...] = ()
    expected_error: float = nan
    expected_mflop: float = 0.0


def previews(
    scenes: Sequence[Scene], *, tolerance: float, method: str = "auto"
) -> Sequence[Preview]:
    """Return the treatment of the scenes by ``solve``; terms that are ``auto`` must be decided."""

    def preview(some: Sequence[Scene]) -> list[Preview]:
        plans = plans_of(needs_of(some), tolerance=tolerance, method=method)
        return [
            _preview(scene, needs_of(scene), plans.get(row), tolerance, method)
            for row, scene in enumerate(some)
        ]

    def failed(error: Exception) -> Preview:
        return Preview(method, status=unexpected(error))

    return each_on_its_own(preview, scenes, failed=failed)


def _preview(
    scene: Scene, need: Needs, plan: Plan | None, tolerance: float, method: str
) -> Preview:
    if isinstance(plan, str):
        return Preview(_named(method), status=plan)
    terms = ("squeeze", *(term.label for term in need.terms))
    if plan:
        return Preview(
            "composite",
            status=plan.status(tolerance),
            domain="whole",
            terms=terms,
            nx=plan.nx,
            ny=plan.ny,
            absent=absent_terms(need.terms),
            expected_error=plan.relative_error,
            expected_mflop=plan.flops / 1e6,
        )
    grids = next(first_grids(need, tolerance=tolerance)).grids
    flops = _expected_flops(scene.closure(), need.terms, grids, tolerance=tolerance)
    return Preview(
        "periodic",
        domain=need.domains[0],
        terms=terms,
        nx=grids[-1].across[0],
        ny=grids[-1].across[1],
        nt=grids[-1].nt,
        absent=absent_terms(need.terms),
        expected_error=tolerance,
        expected_mflop=flops / 1e6,
    )


def _expected_flops(
    epsilon: float, terms: Terms, grids: Sequence[Grid], *, tolerance: float
) -> float:
    """Floating-point operations of the first launch.

    Krylov iterations and Newton steps are fitted to 480 random films (ε 0.02–0.95, σ 10–1e5, half
    of them with inertia up to Re 3, at 1e-3 to 1e-6): from rest to a loose start, from there to the
    tolerance, and on the finer grid.
    """
    from_rest = 5 + 6.5 * epsilon
    refining = 2 + 3.2 * epsilon * log10(1 / tolerance)
    iterations = [from_rest, refining, *[0.75 * refining] * (len(grids) - 2)]
    if len(grids) < 3:  # the first of them goes from rest to the tolerance
        iterations = [from_rest + refining, 0.75 * refining][: len(grids)]
    return sum(n * iteration_flops(grid, terms) for n, grid in zip(iterations, grids, strict=True))
