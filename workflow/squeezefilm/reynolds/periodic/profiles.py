"""The profile under the finger as kernels read it; kept where scenes of a plan share a place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from squeezefilm.film.scene import AtPlace
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.layout import Columns, Joined, Pile, by_stages, joined_each
from squeezefilm.reynolds.periodic.time_modes import Steps, plain_steps, steps_of, time_modes
from squeezefilm.reynolds.problems import (
    Problems,
    mean_motion,
    mean_parts,
    profile_fields,
)
from squeezefilm.reynolds.terms import Terms

# Places of whose profiles the fields are kept.
MOST_PLACES = 256


class _Kept(NamedTuple):
    """The profile at a place: its fields on each grid, and the means of its parts."""

    fields: Joined
    means: Sequence[float]


# By the grids and terms that the fields are for.
_kept: dict[tuple[tuple[Grid, ...], Terms], dict[AtPlace, _Kept]] = {}


def _profiles(problems: Sequence[Problems], grids: Sequence[Grid]) -> list[_Kept]:
    """What is kept of a batch's places; those that are not known yet are found all at once."""
    first = problems[0]
    kept = _kept.setdefault((tuple(grid.in_space for grid in grids), first.terms), {})
    found = [kept.get(at) for at in first.at]
    if new := [place for place, known in enumerate(found) if known is None]:
        some = [replace(each, parts=each.parts[new]) for each in problems]
        fields = joined_each([profile_fields(*each) for each in zip(some, grids, strict=True)])
        means = mean_parts(some[-1], grids[-1]).tolist()
        if sum(map(len, _kept.values())) + len(new) > MOST_PLACES:
            _kept.clear()
        for place, its, its_means in zip(new, fields, means, strict=True):
            kept[first.at[place]] = found[place] = _Kept(its, its_means)
    return [profile for profile in found if profile]


def put_films(
    pile: Pile, problems: Sequence[Problems], grids: Sequence[Grid]
) -> tuple[Columns, Columns]:
    """Put on the pile what a batch's films need beside their numbers: where it lies, on each grid.

    The profiles under the finger, each place's once, and the modes in time, each kind's once.
    """
    places = problems[0].places
    kept = _profiles(problems, grids)
    if kept:
        begins = np.array([pile.put(profile.fields.values) for profile in kept])[places]
        fields = kept[0].fields
        profiles = Columns(fields.names, begins[:, None, None] + fields.starts)
        means = [profile.means for profile in kept]
    else:
        each = zip(problems, grids, strict=True)
        profiles = by_stages([pile.add_each(profile_fields(*on), places) for on in each])
        means = mean_parts(problems[-1], grids[-1]).tolist()
    motions = mean_motion(problems[-1], means)
    if problems[0].terms and problems[0].numbers["lag"].any():
        steps = _lagging_steps(problems[-1], grids, motions)
    else:
        steps = [[plain_steps(*motion) for motion in motions]]
    return profiles, _put_time_modes(pile, steps, grids)


def _put_time_modes(pile: Pile, steps: Sequence[list[Steps]], grids: Sequence[Grid]) -> Columns:
    """Where each film's modes lie, on each grid.

    Args:
        steps: of the films, on each grid or once for all of them.
    """
    columns: dict[tuple[int, int], Columns] = {}
    keys = [(grid.nt, place % len(steps)) for place, grid in enumerate(grids)]
    for instants, place in keys:
        if (instants, place) not in columns:
            columns[instants, place] = _put_modes(pile, instants, steps[place])
    return by_stages([columns[key] for key in keys])


def _put_modes(pile: Pile, instants: int, films: list[Steps]) -> Columns:
    found = {steps: time_modes(instants, steps).parts for steps in dict.fromkeys(films)}
    begins = {steps: pile.put(parts.values) for steps, parts in found.items()}
    parts = found[films[0]]
    begin = np.array([begins[steps] for steps in films])
    return Columns(parts.names, begin[:, None, None] + parts.starts)


def _lagging_steps(
    problems: Problems, grids: Sequence[Grid], motions: Sequence[tuple[float, float]]
) -> list[list[Steps]]:
    """What tells the modes in time of films whose flow lags, on each grid.

    Only how many harmonics lag varies.

    Args:
        problems: the films on the last of the grids.
        motions: of their mean gaps.
    """
    numbers = problems.numbers
    variation, lagging = np.array(motions).T
    steps: list[list[Steps]] = []
    for grid in grids:
        across = max(grid.x.full_points, grid.y.full_points / problems.aspect)
        slow = np.minimum(numbers["slow"], numbers["waves_per_node"] * across / (grid.nt / 2))
        steps.append(steps_of(variation=variation, lagging=lagging, lag=numbers["lag"], slow=slow))
    return steps
