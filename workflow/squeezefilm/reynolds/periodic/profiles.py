"""The profile under the finger as kernels read it; kept where scenes of a plan share a place."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from squeezefilm.film.scene import AtPlace
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.layout import Columns, Joined, Pile, joined
from squeezefilm.reynolds.periodic.time_modes import Steps, plain_steps, steps_of, time_modes
from squeezefilm.reynolds.problems import (
    Problems,
    mean_motion,
    mean_parts,
    problems_on,
    profile_fields,
)
from squeezefilm.reynolds.terms import Terms


def put_profiles(pile: Pile, problems: Sequence[Problems], grids: Sequence[Grid]) -> list[Columns]:
    """Put the profiles of a batch's scenes on the pile; where each lies, on each of its grids."""
    first = problems[0]
    if not first.at:
        each = zip(problems, grids, strict=True)
        return [pile.add_each(profile_fields(some, grid), some.places) for some, grid in each]
    in_space = tuple(grid.in_space for grid in grids)
    known = [_profile_at(at, in_space, first.terms) for at in first.at]
    columns = []
    for on_grid in zip(*known, strict=True):
        begins = np.array([pile.put(profile.values) for profile in on_grid])[first.places, None]
        columns.append(Columns(on_grid[0].columns.names, begins + on_grid[0].columns.values))
    return columns


@lru_cache(maxsize=128)
def _profile_at(at: AtPlace, grids: tuple[Grid, ...], terms: Terms) -> list[Joined]:
    """The profile's fields at a place, on each grid."""
    each = dict.fromkeys(grids, 1.0)
    pairs = zip(problems_on([at.scene], each, terms=terms), each, strict=True)
    fields = {grid: joined(profile_fields(its, grid)) for its, grid in pairs}
    return [fields[grid] for grid in grids]


def put_time_modes(pile: Pile, problems: Problems, grids: Sequence[Grid]) -> list[Columns]:
    """Put the films' modes in time on the pile, each once; where each film's lie, on each grid.

    Args:
        problems: the films on the last of the grids.
    """
    columns: dict[tuple[int, int], Columns] = {}
    keys = []
    for grid, films in zip(grids, _film_steps(problems, grids), strict=True):
        keys.append((grid.nt, id(films)))
        if keys[-1] not in columns:
            columns[keys[-1]] = _put_modes(pile, grid.nt, films)
    return [columns[key] for key in keys]


def _put_modes(pile: Pile, instants: int, films: list[Steps]) -> Columns:
    found = {steps: time_modes(instants, steps).parts for steps in dict.fromkeys(films)}
    begins = {steps: pile.put(parts.values) for steps, parts in found.items()}
    starts = found[films[0]].columns
    begin = np.array([begins[steps] for steps in films])
    return Columns(starts.names, begin[:, None] + starts.values)


def _film_steps(problems: Problems, grids: Sequence[Grid]) -> list[list[Steps]]:
    """What tells the films' modes in time on each grid: only how many harmonics lag varies."""
    numbers = problems.numbers
    if problems.at and not problems.terms:
        at = [_mean_at(each, grids[-1].in_space) for each in problems.at]
        known = zip(problems.places.tolist(), problems.epsilon.tolist(), strict=True)
        return [[plain_steps(at[place] * epsilon) for place, epsilon in known]] * len(grids)
    variation, lagging = mean_motion(problems, grids[-1]).T
    of_grids: list[list[Steps]] = []
    for grid in grids if numbers["lag"].any() else grids[:1]:
        across = max(grid.x.full_points, grid.y.full_points / problems.aspect)
        slow = np.minimum(numbers["slow"], numbers["waves_per_node"] * across / (grid.nt / 2))
        of_grids.append(
            steps_of(variation=variation, lagging=lagging, lag=numbers["lag"], slow=slow)
        )
    return of_grids * (len(grids) // len(of_grids))


@lru_cache(maxsize=1024)
def _mean_at(at: AtPlace, grid: Grid) -> float:
    """The profile at a place averaged over the finger."""
    (problems,) = problems_on([at.scene], {grid: 1.0}, terms=())
    return float(mean_parts(problems, grid)[0, 0])
