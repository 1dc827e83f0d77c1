"""Periodic states on two grids: a quantity's change between the two tells its error."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import UNKNOWN_FALL, left_after, margin_of
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.resolution import least_fall, profile_fall
from squeezefilm.reynolds.plan import plan_of
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.spectral import Around, Axis
from squeezefilm.reynolds.terms import distinct_terms
from squeezefilm.solution import Solution, Solutions


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


def with_states(
    scenes: Scenes, solutions: Solutions, *, tolerance: float, device: Device | None
) -> Solutions:
    """Solutions with their states; those without are solved for, by the periodic method."""
    missing = np.flatnonzero([not states for states in solutions.states])
    if not len(missing):
        return solutions
    how: dict[str, Any] = {"tolerance": tolerance, "device": device}
    solved = solve(scenes[missing], **how, method="periodic", keep_states=True)
    return solutions.with_rows(missing, solved)


def groups_on_equal_grids(
    scenes: Scenes, solutions: Solutions, *, numbers: int
) -> Iterator[np.ndarray]:
    """The rows of scenes whose states are on the same grids, of like terms and pads.

    Args:
        numbers: of the finer states of a group; more would fall out of the caches.
    """
    if not len(scenes):
        return
    kinds, kind = distinct_terms(scenes)
    aspect = np.broadcast_to(scenes.aspect, len(scenes))
    groups: dict[tuple[Any, ...], list[int]] = defaultdict(list)
    for k, states in enumerate(solutions.states):
        if states:
            groups[tuple(state.grid for state in states), kinds[kind[k]], aspect[k]].append(k)
    for (grids, *_), group in groups.items():
        step = max(1, numbers // grids[-1].count)
        for first in range(0, len(group), step):
            yield np.array(group[first : first + step])


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
    scenes, solutions = Scenes.of(scenes), Solutions.of(solutions)
    changes_and_errors = np.full((2, changes, len(scenes)), np.nan)
    for rows in groups_on_equal_grids(scenes, solutions, numbers=MOST_TOGETHER):
        group, solved = scenes[rows], solutions[rows]
        coarse, fine = (
            on_grid(group, [pair.unknowns for pair in states], states[0].grid)
            for states in zip(*solved.states, strict=True)
        )
        factor, _ = remainder(group, solved, tolerance=tolerance)
        changes_and_errors[:, :, rows] = fine, factor * np.abs(fine - coarse) + 2 * tolerance
    return changes_and_errors


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


def remainder(
    scenes: Scenes, solutions: Solutions, *, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the error after a quantity's change between the grids, as for the force.

    Args:
        scenes: of like terms, with states on the same grids.

    Returns:
        The errors in units of that change, and what iterations left of the pressure, in p0: (n,).
    """
    plan, (coarse, fine) = plan_of(scenes), (state.grid.across for state in solutions.states[0])
    fall = np.maximum(
        np.maximum(UNKNOWN_FALL, profile_fall(plan, coarse, fine, tolerance=tolerance)),
        least_fall(scenes),
    )
    # A mass error w moves the pressure by about n w/H.
    left = scenes.gas.polytropic_exponent * solutions.residual / scenes.narrowest
    return margin_of(plan.terms) * left_after(fall), left
