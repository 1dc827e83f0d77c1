"""The treatment that ``solve`` would give scenes: the table of ``simulate --dry-run``."""

from __future__ import annotations

from collections.abc import Sequence
from math import log10
from typing import Any

import numpy as np

from squeezefilm.errors import apply_with_bisection, unexpected_error_status
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.reynolds.grid import Grid, krylov_iteration_flops
from squeezefilm.reynolds.periodic.resolution import first_grids
from squeezefilm.reynolds.plan import solve_plan_of
from squeezefilm.reynolds.solver import known_solutions
from squeezefilm.reynolds.terms import Terms, absent_terms, terms_label
from squeezefilm.solution import Solution

SHOWN_SOLUTION_COLUMNS = ("method", "status", "domain", "terms", "nx", "ny", "nt")


def dry_run(
    scenes: Scenes | Sequence[Scene], *, tolerance: float, method: str = "auto"
) -> Sequence[dict[str, Any]]:
    """Return the treatment of the scenes by ``solve``; terms that are ``auto`` must be decided.

    Returns:
        A row for each scene. ``status`` is that of the solution as far as it is known before
        solving: ``ok``, why there will be no force, or how far the composite expansion is from the
        tolerance. What only solving shows are a tolerance not reached and Newton's failure.
        ``terms`` are solved, ``absent`` those that the equation does not have, with the reasons.
        ``nx``, ``ny``, ``nt`` are points across the pad and over the period, on the finest grid
        expected. ``expected_error`` is relative: the expansion's own estimate, else the tolerance;
        NaN without a force. ``expected_mflop`` are millions of floating-point operations, to within
        a factor of about two.
    """

    def dry_run_rows(some: Scenes) -> list[dict[str, Any]]:
        return _dry_run_rows(some, tolerance=tolerance, method=method)

    def row_of_error(error: Exception) -> dict[str, Any]:
        none = Solution(method=method, status=unexpected_error_status(error))
        return _dry_run_row(none, terms="", absent=(), expected_error=np.nan)

    return apply_with_bisection(dry_run_rows, Scenes.of(scenes), failed=row_of_error)


def _dry_run_row(solution: Solution, *, terms: str, **more: Any) -> dict[str, Any]:
    shown = {
        name: terms if name == "terms" else getattr(solution, name)
        for name in SHOWN_SOLUTION_COLUMNS
    }
    return shown | more | {"expected_mflop": solution.operation_count / 1e6}


def _dry_run_rows(scenes: Scenes, *, tolerance: float, method: str) -> list[dict[str, Any]]:
    plan = solve_plan_of(scenes)
    solutions, found = known_solutions(plan, tolerance=tolerance, method=method)
    expected_error = np.full(len(scenes), np.nan)
    expected_error[found.scene_rows] = found.relative_error
    waiting = np.flatnonzero(solutions.status == "")
    solutions.status[waiting], expected_error[waiting] = "ok", tolerance
    solutions.domain[waiting] = plan.domain[waiting]
    first = first_grids(plan, waiting, tolerance=tolerance) if len(waiting) else ()
    for rows, terms, grids in first:
        solutions.nx[rows], solutions.ny[rows] = grids[-1].nodes_across
        solutions.nt[rows] = grids[-1].nt
        solutions.operation_count[rows] = _expected_flops(
            scenes.closure[rows], terms, grids, tolerance=tolerance
        )
    labels = [terms_label(terms) for terms in plan.term_sets]
    absent = [absent_terms(terms) for terms in plan.term_sets]
    return [
        _dry_run_row(
            solution,
            terms=labels[kind] if solution.domain else "",
            absent=absent[kind] if solution.domain else (),
            expected_error=error,
        )
        for solution, kind, error in zip(
            solutions, plan.term_set_index.tolist(), expected_error.tolist(), strict=True
        )
    ]


def _expected_flops(
    epsilon: np.ndarray, terms: Terms, grids: Sequence[Grid], *, tolerance: float
) -> np.ndarray:
    """Floating-point operations of the first launch, (n,).

    Krylov iterations and Newton steps are fitted to 480 random films (ε 0.02–0.95, σ 10–1e5, half
    of them with inertia up to Re 3, at 1e-3 to 1e-6): from rest to a loose start, from there to the
    tolerance, and on the finer grid.
    """
    from_rest = 5 + 6.5 * epsilon
    refining = 2 + 3.2 * epsilon * log10(1 / tolerance)
    iterations = [from_rest, refining, *[0.75 * refining] * (len(grids) - 2)]
    if len(grids) < 3:  # the first of them goes from rest to the tolerance
        iterations = [from_rest + refining, 0.75 * refining][: len(grids)]
    return sum(
        (
            n * krylov_iteration_flops(grid, terms)
            for n, grid in zip(iterations, grids, strict=True)
        ),
        np.zeros(len(epsilon)),
    )
