"""The periodic states that quantities are functions of, and what a change between them leaves."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.quantities.adjoint import Fields
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import (
    UNKNOWN_FALL,
    least_fall_of,
    left_after,
    margin_of,
)
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.resolution import least_fall, profile_fall
from squeezefilm.reynolds.problems import problems_of
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.terms import stiffness_of, terms_of
from squeezefilm.solution import Solution


def with_states(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution],
    *,
    tolerance: float,
    device: Device | None,
) -> list[Solution]:
    """Solutions with their states; those without are solved for, by the periodic method."""
    missing = [k for k, solution in enumerate(solutions) if not solution.states]
    more = solve(
        [scenes[k] for k in missing],
        tolerance=tolerance,
        method="periodic",
        device=device,
        keep_states=True,
    )
    found = dict(zip(missing, more, strict=True))
    return [found.get(k, solution) for k, solution in enumerate(solutions)]


def alike(
    scenes: Sequence[Scene], solutions: Sequence[Solution], *, numbers: int
) -> Iterator[list[int]]:
    """Scenes whose states are on the same grids, of like terms and pads, by their places.

    Args:
        numbers: of the finer states of a group; more would fall out of the caches.
    """
    groups: dict[object, list[int]] = defaultdict(list)
    for k, (scene, solution) in enumerate(zip(scenes, solutions, strict=True)):
        grids = tuple(state.grid for state in solution.states)
        groups[grids, terms_of(scene), scene.aspect].append(k)
    for group in groups.values():
        step = max(1, numbers // solutions[group[0]].states[-1].grid.count)
        yield from (group[first : first + step] for first in range(0, len(group), step))


def fields_of(scenes: Sequence[Scene], solutions: Sequence[Solution], *, grid: int = -1) -> Fields:
    """The films of ``alike`` scenes, by default on the finer grid."""
    states = [solution.states[grid] for solution in solutions]
    problems = problems_of(scenes, states[0].grid, tolerance=0.0)
    return Fields(problems, states[0].grid, np.stack([each.unknowns[0] for each in states]))


def remainder(scene: Scene, solution: Solution, *, tolerance: float) -> tuple[float, float]:
    """What is left after a quantity's change between the grids, by the rule of the force's error.

    Returns:
        The error in units of that change, and what the iteration left of the pressure, in p0.
    """
    needs, (coarse, fine) = needs_of(scene), (state.grid.across for state in solution.states)
    fall = max(
        UNKNOWN_FALL,
        profile_fall(needs, coarse, fine, tolerance=tolerance).item(),
        least_fall_of(needs.terms),
        least_fall(needs.scenes, coarse[0]).item(),
    )
    # A mass error w moves the pressure by about n w/H.
    left = float(stiffness_of(scene, needs.terms)) * solution.residual / scene.narrowest
    return margin_of(needs.terms) * float(left_after(fall)), left
