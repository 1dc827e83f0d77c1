"""Periodic states on two grids: a quantity's change between the two tells its error."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import UNKNOWN_FALL, left_after, margin_of
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.resolution import least_fall, profile_fall
from squeezefilm.reynolds.plan import plan_of
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


# Numbers of the finer states of films that are solved together.
MOST_TOGETHER = 2**19
# The arrays of a pressure on the edge (terms/edge_pressure.py).
EDGE_PRESSURE = ("edge_values_x", "edge_slope_x", "edge_values_y", "edge_slope_y")


def changes_with_errors(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution],
    on_grid: Callable[[Sequence[Scene], Sequence[np.ndarray], Grid], np.ndarray],
    *,
    changes: int,
    tolerance: float,
) -> np.ndarray:
    """Return relative changes of forces by states beside the scenes' own, and their errors.

    Args:
        solutions: of the scenes, with their states on two grids.
        on_grid: the changes on one grid, (changes, scenes), by scenes that are alike, the unknowns
            of their states, and the grid.
        tolerance: of the iterations of the states.

    Returns:
        Changes and errors, (2, changes, scenes); NaN where a solution has no states.
    """
    found = np.full((2, changes, len(scenes)), np.nan)
    solved = {
        row: (scene, solution)
        for row, (scene, solution) in enumerate(zip(scenes, solutions, strict=True))
        if solution.states
    }
    for group in alike(solved, numbers=MOST_TOGETHER):
        own_scenes, own_solutions = zip(*group.values(), strict=True)
        coarse, fine = (
            on_grid(
                own_scenes,
                [solution.states[k].unknowns for solution in own_solutions],
                own_solutions[0].states[k].grid,
            )
            for k in (0, 1)
        )
        factor = np.array([remainder(*each, tolerance=tolerance)[0] for each in group.values()])
        found[:, :, list(group)] = fine, factor * np.abs(fine - coarse) + 2 * tolerance
    return found


def solved_beside(
    scenes: Sequence[Scene],
    grid: Grid,
    guess: np.ndarray,
    source: np.ndarray,
    *,
    tolerance: float,
    device: Device,
) -> tuple[np.ndarray, np.ndarray]:
    """Solve for the states of films to which a source of mass is added.

    Args:
        guess: unknowns of a state, (scenes, fields, nx, ny, times).
        source: added to the film equation at the unknowns, (scenes, nx, ny, times).

    Returns:
        The mean pressures, (scenes,), NaN where there is no state, and the unknowns.
    """
    ambient = dict.fromkeys(EDGE_PRESSURE, np.zeros_like(source))
    edge = ambient | {"edge_flow": source}
    states = solve_batch(scenes, grid, tolerance=tolerance, device=device, guess=guess, edge=edge)
    return np.where(states.status == 0, states.mean, np.nan), states.unknowns


def remainder(scene: Scene, solution: Solution, *, tolerance: float) -> tuple[float, float]:
    """Return the error after a quantity's change between the grids, as for the force.

    Returns:
        The error in units of that change, and what the iteration left of the pressure, in p0.
    """
    plan, (coarse, fine) = plan_of(scene), (state.grid.across for state in solution.states)
    fall = max(
        UNKNOWN_FALL,
        profile_fall(plan, coarse, fine, tolerance=tolerance).item(),
        least_fall(plan.scenes).item(),
    )
    # A mass error w moves the pressure by about n w/H.
    left = scene.gas.polytropic_exponent * solution.residual / scene.narrowest
    return margin_of(plan.terms) * float(left_after(fall)), left
