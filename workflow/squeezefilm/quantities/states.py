"""Periodic states on two grids: a quantity's change between the two tells its error."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.fields import Fields
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import DEFAULT_CONVERGENCE_RATIO, error_per_change
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.resolution import min_convergence_ratio, profile_error_ratio
from squeezefilm.reynolds.plan import solve_plan_of
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.terms import distinct_term_sets, have_velocity_terms
from squeezefilm.reynolds.terms.edge_pressure import EdgePressure
from squeezefilm.solution import Solution, Solutions

# Of a gas with inertia, or that warms, changes creep or fall suddenly: so many times the change is
# taken. That of a quantity has no size beside it, as that of the force has.
VELOCITY_ERROR_FACTOR = 2.0
# Below this, iterations would end in rounding.
MIN_FORCE_TOLERANCE = 1e-8
# Numbers of the finer states of films that are solved together; more would fall out of the caches.
STATE_VALUES_PER_BATCH = 2**19


def with_states(
    scenes: Scenes, solutions: Solutions, *, tolerance: float, device: Device | None
) -> Solutions:
    """Solutions with their states; those without are solved for, by the periodic method."""
    missing = np.flatnonzero([not states for states in solutions.states])
    if not len(missing):
        return solutions
    how: dict[str, Any] = {"tolerance": tolerance, "device": device}
    solved = solve(scenes[missing], **how, method="periodic", keep_states=True)
    return solutions.with_replaced_rows(missing, solved)


def row_groups_on_equal_grids(scenes: Scenes, solutions: Solutions) -> Iterator[np.ndarray]:
    """The rows of scenes whose states are on the same grids, of like terms and pads."""
    if not len(scenes):
        return
    kinds, kind = distinct_term_sets(scenes)
    aspect = np.broadcast_to(scenes.aspect, len(scenes))
    groups: dict[tuple[Any, ...], list[int]] = defaultdict(list)
    for k, states in enumerate(solutions.states):
        if states:
            groups[tuple(state.grid for state in states), kinds[kind[k]], aspect[k]].append(k)
    for (grids, *_), group in groups.items():
        step = max(1, STATE_VALUES_PER_BATCH // grids[-1].unknown_count)
        for first in range(0, len(group), step):
            yield np.array(group[first : first + step])


def force_changes_and_errors(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution],
    on_grid: Callable[[Fields], np.ndarray],
    *,
    changes: int,
    tolerance: float,
) -> np.ndarray:
    """Return relative changes of forces by states beside the scenes' own, and their errors.

    Args:
        solutions: of the scenes, with their states on two grids.
        on_grid: the changes by the states of like scenes on one grid, (changes, scenes).
        tolerance: of the iterations of the states.

    Returns:
        Changes and errors, (2, changes, scenes); NaN where a solution has no states.
    """
    scenes, solutions = Scenes.of(scenes), Solutions.of(solutions)
    changes_and_errors = np.full((2, changes, len(scenes)), np.nan)
    for rows in row_groups_on_equal_grids(scenes, solutions):
        group, solved = scenes[rows], solutions[rows]
        coarse, fine = (
            on_grid(Fields.of(group, states[0].grid, np.stack([each.unknowns for each in states])))
            for states in zip(*solved.states, strict=True)
        )
        factor, _ = error_per_grid_change(group, solved, tolerance=tolerance)
        changes_and_errors[:, :, rows] = fine, factor * np.abs(fine - coarse) + 2 * tolerance
    return changes_and_errors


def solve_perturbed_states(
    films: Fields, added: Mapping[str, np.ndarray], *, tolerance: float, device: Device
) -> tuple[Fields, np.ndarray]:
    """Solve for states beside some, from these: with a source of mass or a pressure on the edge.

    Args:
        added: to the film equation at the unknowns, (scenes, nx, ny, times), by the names of
            terms/edge_pressure.py: ``edge_flow`` is a source of mass.

    Returns:
        The states, and their mean pressures, (scenes,), NaN where there is none.
    """
    none = dict.fromkeys(EdgePressure.OPERATOR_NAMES, np.zeros_like(films.unknowns[:, 0]))
    how: dict[str, Any] = {"tolerance": tolerance, "device": device, "guess": films.unknowns}
    states = solve_batch(films.scenes, films.grid, **how, terms=films.terms, edge={**none, **added})
    mean = np.where(
        states.status_indices == 0,
        states.mean_pressure_ratio + films.mean(films.edge_gauge_pressure),
        np.nan,
    )
    return replace(films, unknowns=states.unknowns), mean


def error_per_grid_change(
    scenes: Scenes, solutions: Solutions, *, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the error after a quantity's change between the grids, as for the force.

    Args:
        scenes: of like terms, with states on the same grids.

    Returns:
        The errors in units of that change, and what iterations left of the pressure, in p0: (n,).
    """
    plan = solve_plan_of(scenes)
    coarse, fine = (state.grid.nodes_across for state in solutions.states[0])
    fall = np.maximum(
        np.maximum(
            DEFAULT_CONVERGENCE_RATIO, profile_error_ratio(plan, coarse, fine, tolerance=tolerance)
        ),
        min_convergence_ratio(scenes, plan.terms),
    )
    # A mass error w moves the pressure by about n w/H.
    left = scenes.gas.polytropic_exponent * solutions.residual / scenes.narrowest_gap_ratio
    margin = VELOCITY_ERROR_FACTOR if have_velocity_terms(plan.terms) else 1.0
    return margin * error_per_change(fall), left
