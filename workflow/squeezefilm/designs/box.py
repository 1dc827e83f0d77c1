"""The space of an experiment as a box of factors, and where distances in it are taken.

A distance between points needs a common measure of their factors; eq. (12) of the paper does not
name it and the outcome of a design depends on it, so it is always given by name: `coordinates`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError
from squeezefilm.film.positions import POLAR

Array = NDArray[np.float64]
Coordinates = Callable[[Array], Array]

PER_METRE = {"micrometre": 1e6, "metre": 1.0}


@dataclass(frozen=True)
class Box:
    """The space of the experiment: one lower and one upper limit for each named factor."""

    names: tuple[str, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]

    def __post_init__(self) -> None:
        for name, low, high in zip(self.names, self.lower, self.upper, strict=True):
            if not (np.isfinite(low) and np.isfinite(high) and low < high):
                raise InputError(
                    f"box: {name} goes from {low} to {high}; the lower limit must be less than "
                    "the upper one and both finite"
                )

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The limits by the names of the factors."""
        return dict(zip(self.names, zip(self.lower, self.upper, strict=True), strict=True))

    def to_unit(self, points: ArrayLike) -> Array:
        """Points, shape (..., k), with each factor scaled to [0, 1]."""
        low, high = np.array(self.lower), np.array(self.upper)
        return (np.asarray(points, dtype=float) - low) / (high - low)

    def from_unit(self, unit: ArrayLike) -> Array:
        """The inverse of to_unit; the ends of [0, 1] give the limits exactly."""
        low, high, unit = np.array(self.lower), np.array(self.upper), np.asarray(unit, dtype=float)
        return low * (1 - unit) + high * unit


def coordinates(scaling: str, box: Box) -> Coordinates:
    """The coordinates in which distances between points are taken.

    unit: every factor scaled to [0, 1]; micrometre, metre: the factors as they are, all of them
    lengths; scene: h0 and hv scaled to [0, 1], and a polar position as x and y over the largest
    radius, so that two angles at the centre are one and the same scene; a Cartesian one as unit.
    """

    def scene(points: Array) -> Array:
        points = np.asarray(points, dtype=float)
        radius = points[..., 2] / box.upper[2]
        angle = np.deg2rad(points[..., 3])
        position = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
        return np.concatenate([box.to_unit(points)[..., :2], position], axis=-1)

    if scaling in PER_METRE:
        return lambda points: np.asarray(points, dtype=float) * PER_METRE[scaling]
    return scene if scaling == "scene" and box.names[2:] == POLAR else box.to_unit


_pairs = cache(partial(np.triu_indices, k=1))


def pair_distances(points: ArrayLike) -> Array:
    """Distance between every two points of a design, shape (..., N, k) -> (..., N(N-1)/2).

    points are in the coordinates that distances are taken in.
    """
    points = np.asarray(points, dtype=float)
    i, j = _pairs(points.shape[-2])
    return np.linalg.norm(points[..., i, :] - points[..., j, :], axis=-1)


def grid(box: Box, levels: int) -> Array:
    """Points of a regular grid with so many levels per factor, two for the corners alone.

    Shape (levels^k, k).
    """
    axes = np.meshgrid(*[np.linspace(0, 1, levels)] * len(box.names), indexing="ij")
    return box.from_unit(np.stack(axes, axis=-1).reshape(-1, len(box.names)))
