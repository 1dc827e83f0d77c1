"""Modes of a surface fitted to a scan by least squares, up to the degree that describes it best.

Leave-one-out cross-validation says up to which degree they describe the points best; two degrees
more are taken along every side, so that what the profile neglects is small beside what noise does
to it (undersmoothing: Wasserman, All of Nonparametric Statistics, 2006, 5.7). Where there are too
few points for these, the last two degrees estimate the misfit, an error besides the noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.surfaces import ModeOrders, Surface

MAX_MODE_DEGREE = 24
# The fewest points per mode that cross-validation looks at, and for degrees above its best one.
MIN_POINTS_PER_MODE, MIN_POINTS_PER_EXTRA_MODE = 1.5, 3
MAX_CONDITION_NUMBER = 1e8
# One less the leverage of a point that others determine too.
MIN_ONE_MINUS_LEVERAGE = 1e-6
# Degrees above the best by cross-validation, so that the misfit is small beside the noise.
EXTRA_MODE_DEGREES = 2


@dataclass(frozen=True, eq=False)
class ScanPoints:
    """Measurement points of a scan.

    Attributes:
        coordinate: r, x or y, that modes depend on alone; "" if on two.
        x_m, y_m: the points, shape (points,).
        wave_ratio: of the family of modes (surfaces.py).
    """

    surface: Surface
    coordinate: str
    x_m: np.ndarray
    y_m: np.ndarray
    wave_ratio: float = 1.0

    @cached_property
    def with_each_mode_family(self) -> list[ScanPoints]:
        """The same points with each family of the surface's modes."""
        return [replace(self, wave_ratio=ratio) for ratio in self.surface.wave_ratios]

    def subset_of_points(self, rows: np.ndarray | slice) -> ScanPoints:
        """Some of the points."""
        return replace(self, x_m=self.x_m[rows], y_m=self.y_m[rows])

    def mode_values(self, orders: ModeOrders) -> np.ndarray:
        """Values of modes at the points, shape (points, modes)."""
        return self.surface.modes_at(orders, self.x_m, self.y_m)

    def orders_up_to(self, degree: int, *, degrees_more: int = 0) -> ModeOrders:
        """The family's modes up to a degree, and so many degrees more along every side."""
        return self.surface.orders_up_to(
            degree,
            degrees_more=degrees_more,
            coordinate=self.coordinate,
            wave_ratio=self.wave_ratio,
        )

    @cached_property
    def orders_by_degree(self) -> dict[int, ModeOrders]:
        """The modes up to each degree that so many points allow.

        Those of a degree come before those of the next.
        """
        degrees = range(0, MAX_MODE_DEGREE + 1, 2 if self.coordinate == "r" else 1)
        every = {n: self.orders_up_to(n) for n in degrees}
        enough = len(self.x_m) / MIN_POINTS_PER_MODE
        return {n: orders for n, orders in every.items() if len(orders) <= enough}

    @cached_property
    def qr_decomposition(self) -> tuple[np.ndarray, np.ndarray]:
        """The QR decomposition of the modes up to the largest degree, which serves all."""
        q, r = np.linalg.qr(self.mode_values(self.orders_by_degree[max(self.orders_by_degree)]))
        return q, r


@dataclass(frozen=True)
class ModeFit:
    """Least squares on the modes up to one degree.

    ``leave_one_out_error`` is the least rms error, over degrees, at held-out points, and ``root``
    (modes, modes) the factor by which the points' noise enters the coefficients: their covariance
    is noise² root rootᵀ. ``undetermined_coefficients_m`` estimates what degrees add
    that the points do not determine; it is zero where EXTRA_MODE_DEGREES above the best degree are
    taken.
    """

    degree: int
    orders: ModeOrders
    coefficients: np.ndarray
    root: np.ndarray
    leave_one_out_error: float
    undetermined_coefficients_m: np.ndarray


def best_mode_fit(points: ScanPoints, measured: np.ndarray) -> ModeFit:
    """Least squares by the family of modes of least leave-one-out error.

    Raises InputError where the points determine no profile.
    """
    fits = [_best_fit_of_mode_family(family, measured) for family in points.with_each_mode_family]
    return min(fits, key=lambda fit: fit.leave_one_out_error)


def _best_fit_of_mode_family(points: ScanPoints, measured: np.ndarray) -> ModeFit:
    """Least squares, EXTRA_MODE_DEGREES above the degree of least leave-one-out error.

    The error at a left-out point is e/(1 − h), h its leverage, without fitting again (Allen's
    PRESS).

    Raises InputError where the points determine no profile.
    """
    orthogonal, triangle = points.qr_decomposition
    # More modes are never better determined: where the most are, one condition number will do.
    sure = np.linalg.cond(triangle) <= MAX_CONDITION_NUMBER
    scores: dict[int, float] = {}
    for degree, orders in points.orders_by_degree.items():
        count = len(orders)
        determined = sure or np.linalg.cond(triangle[:count, :count]) <= MAX_CONDITION_NUMBER
        score = _leave_one_out_error(orthogonal[:, :count], measured)
        if not determined or not np.isfinite(score):
            break
        scores[degree] = score
    if not scores:
        raise InputError("the points do not determine a profile")
    best = min(scores, key=scores.__getitem__)
    more, orders, orthogonal, triangle = _modes_with_extra_degrees(points, best)
    degree, root = best + more, np.linalg.inv(triangle)
    coefficients = root @ (orthogonal.T @ measured)
    misfit_m = np.zeros_like(coefficients)
    if EXTRA_MODE_DEGREES <= degree < min(best + EXTRA_MODE_DEGREES, MAX_MODE_DEGREE):
        # The change by the last degrees, by so much less as errors at held-out points fall on half
        # the way to them.
        lower_orders = points.orders_by_degree[degree - EXTRA_MODE_DEGREES]
        lower = np.linalg.lstsq(points.mode_values(lower_orders), measured, rcond=None)[0]
        fall = math.sqrt(
            _leave_one_out_error(orthogonal, measured) / scores[degree - EXTRA_MODE_DEGREES]
        )
        change = coefficients.copy()
        change[[orders.index(order) for order in lower_orders]] -= lower
        misfit_m = min(fall, 1.0) * change
    return ModeFit(degree, orders, coefficients, root, scores[best], misfit_m)


def _leave_one_out_error(orthogonal: np.ndarray, measured: np.ndarray) -> float:
    """Rms error at held-out points, one by one; infinite where a point alone determines a mode.

    Args:
        orthogonal: modes made orthonormal at the points, shape (points, modes).
    """
    left = 1 - np.sum(orthogonal**2, axis=1)
    if left.min() < MIN_ONE_MINUS_LEVERAGE:
        return math.inf
    residual = measured - orthogonal @ (orthogonal.T @ measured)
    return float(np.sqrt(np.mean(np.abs(residual / left) ** 2)))


def _modes_with_extra_degrees(
    points: ScanPoints, best: int
) -> tuple[int, ModeOrders, np.ndarray, np.ndarray]:
    """Up to EXTRA_MODE_DEGREES above the best degree: how many, their modes and their QR
    decomposition.

    Along every side of the surface: waves along one side choose a family with few modes along the
    other, where the profile may have a slope that is as small as the noise.
    """
    enough = len(points.x_m) / MIN_POINTS_PER_EXTRA_MODE
    for more in range(min(EXTRA_MODE_DEGREES, MAX_MODE_DEGREE - best), 0, -1):
        orders = points.orders_up_to(best, degrees_more=more)
        if len(points.orders_by_degree[best]) < len(orders) <= enough:
            q, r = np.linalg.qr(points.mode_values(orders))
            left = 1 - np.sum(q**2, axis=1).max()
            if np.linalg.cond(r) <= MAX_CONDITION_NUMBER and left >= MIN_ONE_MINUS_LEVERAGE:
                return more, orders, q, r
    orders = points.orders_by_degree[best]
    return 0, orders, *np.linalg.qr(points.mode_values(orders))
