"""The periodic states that quantities are functions of, and what a change between them leaves."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any

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

UNSOLVED = Solution(status="", method="periodic")


def with_states(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution] | None = None,
    *,
    tolerance: float,
    device: Device | None,
) -> list[Solution]:
    """Solutions with their states; those without are solved for, by the periodic method."""
    found = list(solutions or [UNSOLVED] * len(scenes))
    missing = [k for k, solution in enumerate(found) if not solution.states]
    more = solve(
        [scenes[k] for k in missing],
        tolerance=tolerance,
        method="periodic",
        device=device,
        keep_states=True,
    )
    for k, solution in zip(missing, more, strict=True):
        found[k] = solution
    return found


Solved = dict[int, tuple[Scene, Solution]]
"""Scenes with their solutions and states, by the scenes' places."""


def alike(solved: Solved, *, numbers: int) -> Iterator[Solved]:
    """Scenes whose states are on the same grids, of like terms and pads.

    Args:
        numbers: of the finer states of a group; more would fall out of the caches.
    """
    groups: dict[tuple[Any, ...], list[int]] = defaultdict(list)
    for k, (scene, solution) in solved.items():
        grids = tuple(state.grid for state in solution.states)
        groups[grids, terms_of(scene), scene.aspect].append(k)
    for (grids, *_), group in groups.items():
        step = max(1, numbers // grids[-1].count)
        for first in range(0, len(group), step):
            yield {k: solved[k] for k in group[first : first + step]}


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
