"""Periodic states on two grids: a quantity's change between the two tells its error."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import UNKNOWN_FALL, left_after, margin_of
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.resolution import least_fall, profile_fall
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.spectral import Around, Axis
from squeezefilm.reynolds.terms import terms_of
from squeezefilm.solution import Solution


@lru_cache(maxsize=64)
def weights_with_edge(axis: Axis | Around) -> np.ndarray:
    """Return the weights of the integral along an axis, those of its edge nodes included, (m,).

    A folded axis holds one edge node and the first half of the others.
    """
    if isinstance(axis, Around):
        return axis.weights
    edge = 1 - axis.weights.sum()  # a constant's integral is that constant
    if axis.folded:
        return np.append(edge, axis.weights)
    return np.concatenate([[edge / 2], axis.weights, [edge / 2]])


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


# Scenes with their solutions and states, by the scenes' places.
Solved = dict[int, tuple[Scene, Solution]]


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


def remainder(scene: Scene, solution: Solution, *, tolerance: float) -> tuple[float, float]:
    """Return the error after a quantity's change between the grids, as for the force.

    Returns:
        The error in units of that change, and what the iteration left of the pressure, in p0.
    """
    needs, (coarse, fine) = needs_of(scene), (state.grid.across for state in solution.states)
    fall = max(
        UNKNOWN_FALL,
        profile_fall(needs, coarse, fine, tolerance=tolerance).item(),
        least_fall(needs.scenes).item(),
    )
    # A mass error w moves the pressure by about n w/H.
    left = scene.gas.polytropic_exponent * solution.residual / scene.narrowest
    return margin_of(needs.terms) * float(left_after(fall)), left
