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

    drawn = slice(None, None, -(-len(x_m) // MAX_POINTS))
    positions_m, shape = np.stack([x_m, y_m])[:, drawn], amplitude[drawn]
    if len(orders) >= len(shape) - 2:
        return None
    shape = shape / np.sqrt(np.mean(shape**2))
    varied = np.ptp(positions_m, axis=1) > 0
    half_extent_m = float(np.max(np.ptp(positions_m, axis=1))) / 2

    def residual(offset: np.ndarray, orders_of_parity: ModeOrders) -> np.ndarray:
        about_m = positions_m.copy()
        about_m[varied] -= half_extent_m * offset[:, None]
        modes = surface.modes_at(orders_of_parity, *about_m)
        return np.asarray(shape - modes @ np.linalg.lstsq(modes, shape, rcond=None)[0])

    # Degrees in x and y together: n of a disc's modes (n, m), i + j of a rectangle's (i, j).
    parities = [(order[0] if isinstance(surface, Disc) else sum(order)) % 2 for order in orders]
    start = np.zeros(varied.sum())
    fits = []
    for parity in {*parities}:
        of_parity = tuple(o for o, own in zip(orders, parities, strict=True) if own == parity)
        fits.append((least_squares(residual, start, args=(of_parity,)), len(of_parity)))
    fit, mode_count = min(fits, key=lambda pair: float(pair[0].cost))
    deviation = math.sqrt(2 * fit.cost / (len(shape) - mode_count))
    noise = float(np.linalg.norm(residual(start, orders))) / math.sqrt(len(shape) - len(orders))
    information = fit.jac.T @ fit.jac
    symmetric = deviation <= max(
        MAX_SYMMETRIC_RESIDUAL_RATIO * noise, MAX_SYMMETRIC_RESIDUAL_FRACTION
    )
    if not symmetric or np.linalg.cond(information) > MAX_CONDITION_NUMBER:
        return None
    errors_m = half_extent_m * deviation * np.sqrt(np.diag(np.linalg.inv(information)))
    centre_m = np.zeros(2)
    centre_m[varied] = half_extent_m * fit.x
    return centre_m, NORMAL_QUANTILE_95 * float(errors_m.max())
