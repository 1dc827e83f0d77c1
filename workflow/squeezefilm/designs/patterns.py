"""What several searches for a design have in common: patterns of points, and their union."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from squeezefilm.designs.box import Array, Box
from squeezefilm.designs.paper_design import SINGULAR, Criterion, Design
from squeezefilm.io.errors import InputError

SAME = 0.05
"""Distance in unit factors up to which two points are one."""


@dataclass(frozen=True, eq=False)
class Pattern:
    """Designs that are the same but for the order of their points.

    design is the best of them, members are their places among all designs, excess its value above
    the best pattern's.
    """

    name: str
    design: Design
    members: tuple[int, ...]
    excess: float

    @property
    def count(self) -> int:
        return len(self.members)


@dataclass(frozen=True, eq=False)
class Region:
    """One place in the space of the experiment, shape (k,), and the patterns that have a point
    there; no pattern where the point was added by augmentation."""

    point: Array
    patterns: tuple[str, ...]

    @property
    def origin(self) -> str:
        """The patterns' names, or the word augmentation."""
        return " and ".join(self.patterns) or "augmentation"


def find_patterns(designs: Sequence[Design], box: Box) -> list[Pattern]:
    """Designs gathered into patterns, the best first, named A, B, C ...

    Two designs are the same pattern where their points can be paired so that no pair is further
    apart than SAME. From the best design on, each joins the first pattern whose best design it
    equals in this sense, or starts a new one.
    """
    groups: list[list[int]] = []
    for index in sorted(range(len(designs)), key=lambda index: designs[index].value):
        points = designs[index].points
        alike = (g for g in groups if _mismatch(points, designs[g[0]].points, box) <= SAME)
        group = next(alike, None)
        if group is None:
            groups.append([index])
        else:
            group.append(index)
    best = [designs[group[0]] for group in groups]
    return [
        Pattern(chr(ord("A") + number), design, tuple(group), design.value - best[0].value)
        for number, (design, group) in enumerate(zip(best, groups, strict=True))
    ]


def find_regions(patterns: Sequence[Pattern], box: Box) -> list[Region]:
    """The distinct points of all patterns, each with the patterns it occurs in.

    Of points that are one the first pattern's is kept.
    """
    regions: list[Region] = []
    for pattern in patterns:
        for point in pattern.design.points:
            gaps = [
                float(np.linalg.norm(box.to_unit(point) - box.to_unit(region.point)))
                for region in regions
            ]
            if gaps and min(gaps) <= SAME:
                near = int(np.argmin(gaps))
                known = regions[near].patterns
                names = known if pattern.name in known else (*known, pattern.name)
                regions[near] = Region(regions[near].point, names)
            else:
                regions.append(Region(point, (pattern.name,)))
    return regions


def augment(
    criterion: Criterion,
    regions: Sequence[Region],
    points: int,
    *,
    candidates: Array,
) -> list[Region]:
    """Regions extended to so many points, each time by the candidate with the least criterion.

    The points given stay where they are. candidates has shape (c, k): `corners(box)`, for a free
    point would settle next to one that is there already, the determinant outweighing the distances
    of (12) by far; a simulation has no scatter, and a near replicate teaches nothing.
    Raises InputError where there are more regions than points wanted, or no candidate is left.
    """
    if len(regions) > points:
        raise InputError(
            f"design: {len(regions)} distinct points were found, more than the {points} wanted; "
            f"ask for at least {len(regions)}"
        )
    # Without distances in the criterion a replicate would be as good as any other point.
    spaced = replace(criterion, distance=criterion.distance or criterion.box.to_unit)
    extended = list(regions)
    while len(extended) < points:
        kept = np.array([region.point for region in extended])
        trials = np.concatenate(
            [np.broadcast_to(kept, (len(candidates), *kept.shape)), candidates[:, None]], axis=1
        )
        values = spaced.value(trials)
        if values.min() >= SINGULAR:
            raise InputError("design: no candidate is left for another point; give more candidates")
        extended.append(Region(candidates[int(np.argmin(values))], ()))
    return extended


def _mismatch(points: Array, others: Array, box: Box) -> float:
    """Largest distance within pairs of points of two designs, paired by least squares."""
    if len(points) != len(others):
        return float("inf")
    gaps = np.linalg.norm(box.to_unit(points)[:, None] - box.to_unit(others)[None], axis=-1)
    return float(gaps[linear_sum_assignment(gaps**2)].max())
