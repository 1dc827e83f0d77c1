"""The profile under the finger as kernels read it; kept where scenes of a plan share a place."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from squeezefilm.film.scene import AtPlace
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.layout import Columns, Joined, Pile, joined
from squeezefilm.reynolds.periodic.time_modes import Steps, steps_of
from squeezefilm.reynolds.problems import Problems, mean_motion, problems_on, profile_fields
from squeezefilm.reynolds.terms import Terms


def put_profiles(pile: Pile, problems: Sequence[Problems], grids: Sequence[Grid]) -> list[Columns]:
    """Put the profiles of a batch's scenes on the pile; where each lies, on each of its grids."""
    first = problems[0]
    if not first.at:
        each = zip(problems, grids, strict=True)
        return [pile.add_each(profile_fields(some, grid), some.places) for some, grid in each]
    known = [_profile_at(at, tuple(grids), first.terms) for at in first.at]
    columns = []
    for on_grid in zip(*known, strict=True):
        begins = np.array([pile.put(profile.values) for profile in on_grid])[first.places, None]
        columns.append(Columns(on_grid[0].columns.names, begins + on_grid[0].columns.values))
    return columns


@lru_cache(maxsize=128)
def _profile_at(at: AtPlace, grids: tuple[Grid, ...], terms: Terms) -> list[Joined]:
    """The profile's fields at a place, on each grid."""
    problems = problems_on([at.scene], dict.fromkeys(grids, 1.0), terms=terms)
    return [joined(profile_fields(*each)) for each in zip(problems, grids, strict=True)]


def film_steps(problems: Problems, grid: Grid) -> list[Steps]:
    """What tells the films' modes in time, which are alike on all grids."""
    numbers = problems.numbers
    variation, lagging = mean_motion(problems, grid).T
    return steps_of(variation=variation, lagging=lagging, lag=numbers["lag"], slow=numbers["slow"])
