"""What will be done about a scene, at what cost, and what is left out and why, unsolved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log10, nan

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.asymptotics.scenes import Expanded
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import LeftOut, Needs, needs_of
from squeezefilm.reynolds.periodic.resolution import first_grids
from squeezefilm.reynolds.periodic.sizes import iteration_flops
from squeezefilm.reynolds.plan import PERIODIC, Plan, plans_of
from squeezefilm.reynolds.solver import each_on_its_own, unexpected
from squeezefilm.reynolds.terms import Terms, left_out_of


@dataclass(frozen=True)
class Explanation:
    """One scene's way to its force.

    Attributes:
        method: name of the method.
        status: that of the solution as far as it is known before solving: ``ok``, why there will
            be no force, or how far a limit asked for by name is from the tolerance. What only
            solving shows are a tolerance not reached, Newton's failure and a gas too rarefied.
        domain: ``whole``, ``half`` or ``quarter`` of the finger; empty where nothing is solved.
        terms: the terms of the equation that are solved.
        nx, ny, nt: points across the finger and over the period, on the finest grid expected.
        left_out: what the scene does not need, with the reasons.
        expected_error: relative; a limit's own estimate, else the tolerance; NaN without a force.
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


def explain(
    scenes: Sequence[Scene], *, tolerance: float, method: str = "auto"
) -> Sequence[Explanation]:
    """How ``solve`` will treat the scenes; its arguments. What is ``auto`` has to be decided."""

    def ways(some: Sequence[Scene]) -> list[Explanation]:
        plans = plans_of(needs_of(some), tolerance=tolerance, method=method)
        return [
            _explanation(scene, needs_of(scene), plans.get(row, PERIODIC), tolerance=tolerance)
            for row, scene in enumerate(some)
        ]

    def failed(error: Exception) -> Explanation:
        return Explanation(method, status=unexpected(error))

    return each_on_its_own(ways, scenes, failed=failed)


def _explanation(scene: Scene, need: Needs, way: Plan, *, tolerance: float) -> Explanation:
    if way.refused:
        return Explanation(way.method, status=way.refused)
    if way.expanded is not None:
        explanation = _by_limit(need, way.expanded, tolerance=tolerance)
    else:
        explanation = _on_grids(scene, need, tolerance=tolerance)
    return replace(explanation, terms=("squeeze", *(term.label for term in need.terms)))


def _by_limit(need: Needs, result: Expanded, *, tolerance: float) -> Explanation:
    return Explanation(
        method="composite",
        status=result.status(tolerance),
        domain="whole",
        nx=result.nx,
        ny=result.ny,
        left_out=(result.left_out, *left_out_of(need.terms)),
        expected_error=result.relative_error,
        expected_mflop=result.flops / 1e6,
    )


def _on_grids(scene: Scene, need: Needs, *, tolerance: float) -> Explanation:
    (grids,), _ = first_grids(need, tolerance=tolerance)
    finest = grids[-1]
    return Explanation(
        method="periodic",
        domain=_domain(bool(need.fold_x[0]), bool(need.fold_y[0])),
        nx=finest.x.full_points,
        ny=finest.y.full_points,
        nt=finest.nt,
        left_out=need.simplifications(0),
        expected_error=tolerance,
        expected_mflop=_expected_flops(scene.closure(), need.terms, grids, tolerance=tolerance)
        * _times_under_outline(scene)
        / 1e6,
    )


def _domain(fold_x: bool, fold_y: bool) -> str:
    return ("whole", "half", "quarter")[fold_x + fold_y]


def _expected_flops(
    epsilon: float, terms: Terms, grids: Sequence[Grid], *, tolerance: float
) -> float:
    """Floating-point operations of the first launch.

    Krylov iterations and Newton steps are fitted to 480 random films (ε 0.02–0.95, σ 10–1e5, half
    of them with inertia up to Re 3, at 1e-3 to 1e-6): from rest to a loose start, from there to the
    tolerance, and on each finer grid. On coarse grids that tell the error the first two add up to
    about the same.
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
