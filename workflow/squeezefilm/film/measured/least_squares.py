"""Least squares on a surface's smooth modes, the degree by cross-validation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.surfaces import Orders, Surface

LARGEST_DEGREE = 24
POINTS_PER_MODE = 3
LARGEST_CONDITION = 1e8
# Degrees above the best by cross-validation, so that the misfit is small beside the noise.
DEGREES_MORE = 2
# An axisymmetric profile is doubted where angles leave less than this share of what it leaves, and
# the points that this is looked at with.
LESS_WITH_ANGLES, MOST_LOOKED_AT = 0.5, 2000


@dataclass(frozen=True, eq=False)
class Points:
    """Where a scan was measured.

    Attributes:
        axisymmetric: whether modes have no angles.
        x_m, y_m: the points, shape (points,).
    """

    surface: Surface
    axisymmetric: bool
    x_m: np.ndarray
    y_m: np.ndarray

    def some(self, rows: np.ndarray | slice) -> Points:
        """Some of the points."""
        return replace(self, x_m=self.x_m[rows], y_m=self.y_m[rows])

    def modes(self, orders: Orders) -> np.ndarray:
        """Values of modes at the points, shape (points, modes)."""
        return self.surface.modes_at(orders, self.x_m, self.y_m)

    @cached_property
    def orders(self) -> dict[int, Orders]:
        """The modes up to each degree that so many points allow.

        Those of a degree come before those of the next.
        """
        degrees = range(0, LARGEST_DEGREE + 1, 2 if self.axisymmetric else 1)
        every = {n: self.surface.orders_up_to(n, axisymmetric=self.axisymmetric) for n in degrees}
        enough = len(self.x_m) / POINTS_PER_MODE
        return {n: orders for n, orders in every.items() if len(orders) <= enough}

    @cached_property
    def decomposed(self) -> tuple[np.ndarray, np.ndarray]:
        """The QR decomposition of the modes up to the largest degree, which serves all."""
        q, r = np.linalg.qr(self.modes(self.orders[max(self.orders)]))
        return q, r


@dataclass(frozen=True)
class Fit:
    """Least squares on the modes up to one degree.

    ``score`` is the least rms error, over degrees, at points left out, and ``root`` (modes, modes)
    the factor by which the points' noise enters the coefficients: their covariance is
    noise² root rootᵀ.
    """

    degree: int
    orders: Orders
    coefficients: np.ndarray
    root: np.ndarray
    score: float


def best_fit(points: Points, measured: np.ndarray) -> Fit:
    """Least squares, DEGREES_MORE above the degree of least leave-one-out error.

    The error at a left-out point is e/(1 − h), h its leverage, without fitting again (Allen's
    PRESS).

    Raises InputError where the points determine no profile.
    """
    orthogonal, triangle = points.decomposed
    along = orthogonal.T @ measured
    # More modes are never better determined: where the most are, one condition number will do.
    sure = np.linalg.cond(triangle) <= LARGEST_CONDITION
    scores: dict[int, float] = {}
    for degree, orders in points.orders.items():
        count = len(orders)
        leverage = np.sum(orthogonal[:, :count] ** 2, axis=1)
        determined = sure or np.linalg.cond(triangle[:count, :count]) <= LARGEST_CONDITION
        if not determined or leverage.max() > 1 - 1e-6:
            break
        residual = measured - orthogonal[:, :count] @ along[:count]
        scores[degree] = float(np.sqrt(np.mean(np.abs(residual / (1 - leverage)) ** 2)))
    if not scores:
        raise InputError("the points do not determine a profile")
    best = min(scores, key=scores.__getitem__)
    degree = max(each for each in scores if each <= best + DEGREES_MORE)
    count = len(points.orders[degree])
    root = np.linalg.inv(triangle[:count, :count])
    return Fit(degree, points.orders[degree], root @ along[:count], root, scores[best])


def wants_angles(points: Points, measured: np.ndarray, fit: Fit) -> list[str]:
    """A note where a profile with angles leaves far less."""
    some = slice(None, None, -(-len(measured) // MOST_LOOKED_AT))
    try:
        free = best_fit(replace(points.some(some), axisymmetric=False), measured[some])
    except InputError:  # too few points for angles
        return []
    share = free.score / fit.score
    return [
        f"the scan is not axisymmetric: a profile with angles leaves {share:.2g} of what this one "
        "does, and no noise or error here holds; say actuator.profile.axisymmetric: false"
    ] * (share <= LESS_WITH_ANGLES)
