"""What a scene needs, decided before anything is solved: method, domain, terms, first grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log10, nan

import numpy as np

from squeezefilm.errors import each_on_its_own, unexpected
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.asymptotics.composite import Expanded, composite, not_derived_for
from squeezefilm.reynolds.grid import Grid, iteration_flops
from squeezefilm.reynolds.needs import LeftOut, Needs, needs_of
from squeezefilm.reynolds.periodic.resolution import first_grids, unseen_profiles
from squeezefilm.reynolds.terms import Terms, first_reason, left_out_of

METHODS = ("auto", "composite", "periodic")


@dataclass(frozen=True)
class Plan:
    """How a scene is treated.

    Attributes:
        method: by which its force is computed, or would be.
        expanded: the force by the composite expansion; None where the full equation is solved.
        refused: why there will be no force; empty where it is tried.
    """

    method: str
    expanded: Expanded | None = None
    refused: str = ""


PERIODIC = Plan("periodic")


def plans_of(needs: Needs, *, tolerance: float, method: str) -> dict[int, Plan]:
    """How ``solve`` treats scenes, as far as that is decided before solving.

    By row, of those that are not solved as PERIODIC.
    """
    unseen = unseen_profiles(needs, tolerance=tolerance)
    named = "periodic" if method == "auto" else method
    plans = {row: Plan(named, refused=reason) for row, reason in unseen.items()}
    if method != "periodic":
        seen = np.delete(np.arange(len(needs)), list(unseen))
        some = needs[seen] if unseen else needs
        found = composite(some, tolerance=tolerance, worth=method == "auto")
        rows = seen.tolist()
        plans |= {rows[at]: Plan("composite", expanded=each) for at, each in found.items()}
        if method == "composite":
            reasons = {rows[at]: reason for at, reason in not_derived_for(some).items()}
            return {row: Plan(method, refused=reason) for row, reason in reasons.items()} | plans
    return needs.once("on grids", lambda: _refused_on_grids(needs)) | plans


def _refused_on_grids(needs: Needs) -> dict[int, Plan]:
    """The scenes whose terms the periodic state does not have, and why: by their films alone."""
    refused: dict[int, Plan] = {}
    for rows, scene, terms in needs.alike():
        if reason := first_reason(term.refused_on_grid(scene) for term in terms):
            refused |= dict.fromkeys(rows.tolist(), Plan("periodic", refused=reason))
    return refused


@dataclass(frozen=True)
class Preview:
    """One scene's way to its force, unsolved.

    Attributes:
        method: name of the method.
        status: that of the solution as far as it is known before solving: ``ok``, why there will
            be no force, or how far the composite expansion is from the tolerance. What only
            solving shows are a tolerance not reached, Newton's failure and a gas too rarefied.
        domain: ``whole``, ``half`` or ``quarter`` of the pad; empty where nothing is solved.
        terms: the terms of the equation that are solved.
        nx, ny, nt: points across the pad and over the period, on the finest grid expected.
        left_out: what the scene does not need, with the reasons.
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
    left_out: tuple[LeftOut, ...] = ()
    expected_error: float = nan
    expected_mflop: float = 0.0


def previews(
    scenes: Sequence[Scene], *, tolerance: float, method: str = "auto"
) -> Sequence[Preview]:
    """How ``solve`` will treat the scenes; its arguments. What is ``auto`` has to be decided."""

    def preview(some: Sequence[Scene]) -> list[Preview]:
        plans = plans_of(needs_of(some), tolerance=tolerance, method=method)
        return [
            _preview(scene, needs_of(scene), plans.get(row, PERIODIC), tolerance=tolerance)
            for row, scene in enumerate(some)
        ]

    def failed(error: Exception) -> Preview:
        return Preview(method, status=unexpected(error))

    return each_on_its_own(preview, scenes, failed=failed)


def _preview(scene: Scene, need: Needs, plan: Plan, *, tolerance: float) -> Preview:
    if plan.refused:
        return Preview(plan.method, status=plan.refused)
    terms = ("squeeze", *(term.label for term in need.terms))
    if expanded := plan.expanded:
        return Preview(
            plan.method,
            status=expanded.status(tolerance),
            domain="whole",
            terms=terms,
            nx=expanded.nx,
            ny=expanded.ny,
            left_out=(expanded.left_out, *left_out_of(need.terms)),
            expected_error=expanded.relative_error,
            expected_mflop=expanded.flops / 1e6,
        )
    grids = next(first_grids(need, tolerance=tolerance)).grids
    flops = _expected_flops(scene.closure(), need.terms, grids, tolerance=tolerance)
    return Preview(
        plan.method,
        domain=("whole", "half", "quarter")[int(need.fold_x[0]) + int(need.fold_y[0])],
        terms=terms,
        nx=grids[-1].x.full_points,
        ny=grids[-1].y.full_points,
        nt=grids[-1].nt,
        left_out=need.simplifications(0),
        expected_error=tolerance,
        expected_mflop=flops * _times_under_outline(scene) / 1e6,
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


def _times_under_outline(scene: Scene) -> float:
    """How many times the iterations under a rectangle those under a smooth outline are.

    Its preconditioner takes the area behind each point for equal: fitted to 80 ellipses (ε
    0.02–0.9, σ 1–1e5, axes up to 1:3), mostly right within a factor of two.
    """
    outline = scene.finger.smooth_outline
    return 1 + 0.4 * outline.rim * log10(1 + scene.sigma) ** 2 if outline else 1.0
