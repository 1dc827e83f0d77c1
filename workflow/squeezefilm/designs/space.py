"""The space of an experiment: limits of its factors, and where distances in it are taken.

A distance between points needs a common measure of their factors; eq. (12) of the paper does not
name it and the outcome of a design depends on it, so it is always given by name:
`coordinate_function`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError
from squeezefilm.film.positions import POLAR_COLUMNS

Array = NDArray[np.float64]
CoordinateFunction = Callable[[Array], Array]

UNITS_PER_METRE = {"micrometre": 1e6, "metre": 1.0}


def all_allowed_mask(points: Array) -> NDArray[np.bool_]:
    """The mask of a space all of which can be simulated."""
    return np.ones(len(points), dtype=bool)


@dataclass(frozen=True)
class Space:
    """The space of the experiment: limits of each factor, and the points that can be simulated.

    Attributes:
        limits: the lower and the upper one by the factors' names, in the order of a point's values.
        allowed_mask: mask, shape (n,), of the points, shape (n, k), that can be simulated.
        position_columns: the form in which positions stand in tables of its points.
    """

    limits: dict[str, tuple[float, float]]
    allowed_mask: Callable[[Array], NDArray[np.bool_]] = all_allowed_mask
    position_columns: tuple[str, str] = POLAR_COLUMNS

    def __post_init__(self) -> None:
        for name, (low, high) in self.limits.items():
            if not (np.isfinite(low) and np.isfinite(high) and low < high):
                raise InputError(
                    f"space: {name} goes from {low} to {high}; the lower limit must be less than "
                    "the upper one and both finite"
                )

    @property
    def names(self) -> tuple[str, ...]:
        """The factors."""
        return tuple(self.limits)

    @property
    def limits_of_all_factors(self) -> dict[str, tuple[float, float]]:
        """The limits of all four factors; those of the position of a centred pad are zero."""
        return {
            **self.limits,
            **{name: self.limits.get(name, (0.0, 0.0)) for name in self.position_columns},
        }

    @property
    def lower_and_upper_limits(self) -> Array:
        """The lower and the upper limits, shape (2, k)."""
        return np.transpose(list(self.limits.values()))

    def to_unit(self, points: ArrayLike) -> Array:
        """Points, shape (..., k), with each factor scaled to [0, 1]."""
        low, high = self.lower_and_upper_limits
        return np.asarray((np.asarray(points, dtype=float) - low) / (high - low))

    def from_unit(self, unit: ArrayLike) -> Array:
        """The inverse of to_unit; the ends of [0, 1] give the limits exactly."""
        (low, high), unit = self.lower_and_upper_limits, np.asarray(unit, dtype=float)
        return np.asarray(low * (1 - unit) + high * unit)

    def levels(self, count: int) -> Array:
        """Points of a regular grid with so many levels per factor, two for the corners alone.

        Shape (count^k, k).
        """
        axes = np.meshgrid(*[np.linspace(0, 1, count)] * len(self.limits), indexing="ij")
        return self.from_unit(np.stack(axes, axis=-1).reshape(-1, len(self.limits)))

    def grid(self, most: int, *, distinct: bool) -> Array:
        """A grid of at most so many points, limits included, without those not allowed.

        With distinct=True the directions of a pad at the centre, which are one and the same
        scene, come once.
        """
        points = self.levels(max(2, int(most ** (1 / len(self.limits)) + 1e-9)))
        if distinct and "phi_deg" in self.limits:
            first, last = self.limits["phi_deg"]
            if last - first == 360:  # the last direction is the first again
                points = points[points[:, 3] < last]
            points = points[(points[:, 2] > 0) | (points[:, 3] == first)]
        return points[self.allowed_mask(points)]

    def sample(self, points: int, *, seed: int) -> Array:
        """A fair sample of the space: every place is as likely as any other.

        From a scrambled Halton sequence, whose points keep out of each other's way: means over a
        few of them scatter less than over independent points. Those not allowed are excluded.
        """
        from scipy.stats import qmc  # slow to import, and only needed here

        return self._allowed_sample(points, qmc.Halton(len(self.limits), rng=seed).random)

    def independent_sample(self, points: int, *, seed: int) -> Array:
        """Independent points, uniform over the factors' limits; those not allowed are excluded."""
        random = np.random.default_rng(seed)
        return self._allowed_sample(points, lambda count: random.random((count, len(self.limits))))

    def _allowed_sample(self, points: int, draw: Callable[[int], Array]) -> Array:
        kept = np.empty((0, len(self.limits)))
        for _ in range(100):
            drawn = self.from_unit(draw(points))
            kept = np.concatenate([kept, drawn[self.allowed_mask(drawn)]])
            if len(kept) >= points:
                return kept[:points]
        raise InputError("positions: hardly any pad position of the study lies on the surface")


def coordinate_function(scaling: str, space: Space) -> CoordinateFunction:
    """The coordinates in which distances between points are taken.

    unit: every factor scaled to [0, 1]; micrometre, metre: the factors as they are, all of them
    lengths; scene: h0 and hv scaled to [0, 1], and a polar position as x and y over the largest
    radius, so that two angles at the centre are one and the same scene; a Cartesian one as unit.
    """

    def scene_coordinates(points: Array) -> Array:
        points = np.asarray(points, dtype=float)
        radius = points[..., 2] / space.limits["phi_r_m"][1]
        angle = np.deg2rad(points[..., 3])
        position = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
        return np.concatenate([space.to_unit(points)[..., :2], position], axis=-1)

    if scaling in UNITS_PER_METRE:
        return lambda points: np.asarray(points, dtype=float) * UNITS_PER_METRE[scaling]
    return (
        scene_coordinates
        if scaling == "scene" and space.names[2:] == POLAR_COLUMNS
        else space.to_unit
    )


_pair_indices = cache(partial(np.triu_indices, k=1))


def pair_distances(points: ArrayLike) -> Array:
    """Distance between every two points of a design, shape (..., N, k) -> (..., N(N-1)/2).

    points are in the coordinates that distances are taken in.
    """
    points = np.asarray(points, dtype=float)
    i, j = _pair_indices(points.shape[-2])
    return np.linalg.norm(points[..., i, :] - points[..., j, :], axis=-1)
