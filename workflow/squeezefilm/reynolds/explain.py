"""What will be done about a scene, at what cost, and what is left out and why, unsolved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log10, sqrt

from squeezefilm.reynolds import galerkin
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import LeftOut, Needs, needs_of
from squeezefilm.reynolds.refinement import first_grids, iteration_flops
from squeezefilm.reynolds.solver import by_limits
from squeezefilm.scene import Scene


@dataclass(frozen=True)
class Explanation:
    """One scene's way to its force.

    Attributes:
        method: name of the method.
        domain: ``whole``, ``half`` or ``quarter`` of the finger.
        terms: the terms of the equation that are solved.
        nx, ny, nt: points across the finger and over the period, on the finest grid expected; for
            an elliptical finger along a radius and around.
        left_out: what the scene does not need, with the reasons.
        expected_error: relative; a limit's own estimate, else the tolerance.
        expected_mflop: millions of floating-point operations, to within a factor of about two.
    """

    method: str
    domain: str
    terms: tuple[str, ...]
    nx: int
    ny: int
    nt: int
    left_out: tuple[LeftOut, ...]
    expected_error: float
    expected_mflop: float


def explain(
    scenes: Sequence[Scene], *, tolerance: float, method: str = "auto"
) -> list[Explanation]:
    """How ``solve`` would treat the scenes; its arguments."""
    needs = [needs_of(scene) for scene in scenes]
    limits = by_limits(scenes, needs, tolerance=tolerance, method=method)
    explanations = []
    for index, (scene, need) in enumerate(zip(scenes, needs, strict=True)):
        terms = ["squeeze"]
        terms += ["bearing"] * need.bearing
        terms += [scene.gas.rarefaction] * (need.flow_terms > 1)
        terms += ["polytropic gas"] * need.polytropic
        if index in limits:
            result = limits[index]
            explanations.append(
                Explanation(
                    method=result.method,
                    domain="whole",
                    terms=tuple(terms),
                    nx=result.nx,
                    ny=result.ny,
                    nt=0,
                    left_out=(result.left_out, *need.terms_left_out),
                    expected_error=result.error / abs(result.mean),
                    expected_mflop=result.flops / 1e6,
                )
            )
            continue
        if galerkin.wants_modes(scene):
            explanations.append(_in_modes(scene, need, terms, tolerance=tolerance))
            continue
        grids = first_grids(scene, need, tolerance=tolerance)
        finest = grids[-1]
        explanations.append(
            Explanation(
                method="periodic",
                domain=("whole", "half", "quarter")[need.fold_x + need.fold_y],
                terms=tuple(terms),
                nx=finest.x.full_points,
                ny=finest.y.full_points,
                nt=finest.nt,
                left_out=need.halves_left_out + need.terms_left_out,
                expected_error=tolerance,
                expected_mflop=_expected_flops(scene.epsilon, grids, tolerance=tolerance) / 1e6,
            )
        )
    return explanations


def _in_modes(scene: Scene, need: Needs, terms: Sequence[str], *, tolerance: float) -> Explanation:
    """The way of a scene that is solved in the modes of its pad."""
    first = galerkin.first_resolution(scene, need, tolerance=tolerance)
    finest = first.finer
    work = _iterations_in_modes(scene.closure()) * first.flops
    return Explanation(
        method=galerkin.METHOD,
        domain=("whole", "half", "quarter")[first.pad.fold_x + first.pad.fold_y],
        terms=tuple(terms),
        nx=finest.pad.points[0],
        ny=finest.pad.points[1],
        nt=finest.instants,
        left_out=galerkin.halves_left_out(first, need) + need.terms_left_out,
        expected_error=tolerance,
        expected_mflop=(work + 6 * finest.flops) / 1e6,
    )


def _expected_flops(epsilon: float, grids: Sequence[Grid], *, tolerance: float) -> float:
    """Floating-point operations of the first launch.

    Krylov iterations and Newton steps are fitted to 500 random films (ε 0.01–0.98, σ 0.1–1e6): from
    rest to a loose start, from there to the tolerance, and on the finer grid.
    """
    from_rest = 4 + 10 * epsilon / sqrt(1 - epsilon)
    refining = from_rest * log10(1 / tolerance) / 4
    iterations = [from_rest, refining, 0.7 * refining][-len(grids) :]
    if len(grids) < 3:  # the first of them goes from rest to the tolerance
        iterations[0] += from_rest
    return sum(n * iteration_flops(grid) for n, grid in zip(iterations, grids, strict=True))


def _iterations_in_modes(epsilon: float) -> float:
    """Krylov iterations and Newton steps from rest on the first grid (fitted, ε 0.05–0.95)."""
    return 8 + 15 * epsilon / (1 - epsilon) ** 0.5
