"""The centre of a vibrating surface in the coordinates of its scan, by the shape's symmetry.

Modes of a disc or a rectangle are even or odd in x and y together about its centre. The centre of a
scan whose origin is elsewhere is therefore where even modes alone, or odd ones, fit it best; the
middle of the points' extents misses it by up to half their distance.
"""

from __future__ import annotations

import math

import numpy as np

from squeezefilm.film.surfaces import Disc, ModeOrders, Surface

# A shape is symmetric if even or odd modes leave no more than so much of what all modes do, or this
# share of its rms amplitude.
MAX_SYMMETRIC_RESIDUAL_RATIO, MAX_SYMMETRIC_RESIDUAL_FRACTION = 1.2, 0.003
# More points are not looked at; and a shape along lines has a centre on one of them anywhere.
MAX_POINTS, MAX_CONDITION_NUMBER = 2000, 100
NORMAL_QUANTILE_95 = 1.96


def centre_of_symmetry(
    x_m: np.ndarray, y_m: np.ndarray, amplitude: np.ndarray, surface: Surface, orders: ModeOrders
) -> tuple[np.ndarray, float] | None:
    """The centre of symmetry near the origin and its error (95 %); None if there is none.

    Args:
        amplitude: real, at points x_m, y_m.
        orders: the surface's modes that describe the shape.
    """
    from scipy.optimize import least_squares

    every = slice(None, None, -(-len(x_m) // MAX_POINTS))
    places, u = np.stack([x_m, y_m])[:, every], amplitude[every]
    u = u / np.sqrt(np.mean(u**2))
    free = np.ptp(places, axis=1) > 0
    size_m = float(np.max(np.ptp(places, axis=1))) / 2

    def residual(shift: np.ndarray, some: ModeOrders) -> np.ndarray:
        moved = places.copy()
        moved[free] -= size_m * shift[:, None]
        modes = surface.modes_at(some, *moved)
        return np.asarray(u - modes @ np.linalg.lstsq(modes, u, rcond=None)[0])

    start = np.zeros(free.sum())
    # Degrees in x and y together: n of a disc's modes (n, m), i + j of a rectangle's (i, j).
    odd = [(order[0] if isinstance(surface, Disc) else sum(order)) % 2 for order in orders]
    halves = [
        tuple(order for order, side in zip(orders, odd, strict=True) if side == parity)
        for parity in {*odd}
    ]
    if len(orders) >= len(u) - 2:
        return None
    fits = [(least_squares(residual, start, args=(some,)), len(some)) for some in halves]
    fit, modes = min(fits, key=lambda each: float(each[0].cost))
    deviation = math.sqrt(2 * fit.cost / (len(u) - modes))
    noise = float(np.linalg.norm(residual(start, orders))) / math.sqrt(len(u) - len(orders))
    information = fit.jac.T @ fit.jac
    if (
        deviation > max(MAX_SYMMETRIC_RESIDUAL_RATIO * noise, MAX_SYMMETRIC_RESIDUAL_FRACTION)
        or np.linalg.cond(information) > MAX_CONDITION_NUMBER
    ):
        return None
    errors_m = size_m * deviation * np.sqrt(np.diag(np.linalg.inv(information)))
    place_m = np.zeros(2)
    place_m[free] = size_m * fit.x
    return place_m, NORMAL_QUANTILE_95 * float(errors_m.max())
