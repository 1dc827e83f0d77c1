"""The largest magnitude of sums of smooth modes, and what noise adds to it."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from squeezefilm.film.vibration.least_squares import Fit
from squeezefilm.film.vibration.surfaces import Surface

PEAK_DRAWS, PEAK_SEED = 200, 1

Parts = Sequence[tuple[np.ndarray, tuple[tuple[int, int], ...]]]
"""Sums of modes in one phase or two: coefficients, shape (sums, modes), and the modes' orders."""


def largest_on_net(parts: Parts, surface: Surface) -> np.ndarray:
    """Largest magnitude on the net, shape (sums,)."""
    values = [each @ _net_of_modes(orders, surface).T for each, orders in parts]
    size = np.abs(values[0]) if len(values) == 1 else np.hypot(*values)
    return np.asarray(size.max(axis=1))


def bias_of_largest(fits: Sequence[Fit], noise_m: float, surface: Surface) -> float:
    """By how much noise raises the largest magnitude, by what more of it would do."""
    random = np.random.default_rng(PEAK_SEED)
    drawn: list[tuple[np.ndarray, tuple[tuple[int, int], ...]]] = []
    for fit in fits:
        change = noise_m * random.standard_normal((PEAK_DRAWS, len(fit.orders))) @ fit.root.T
        # Every draw and its mirror image: without curvature the mean is zero, not nearly so.
        drawn.append((fit.coefficients + np.concatenate([change, -change]), fit.orders))
    found = largest_on_net([(fit.coefficients[None], fit.orders) for fit in fits], surface)[0]
    return max(float(largest_on_net(drawn, surface).mean() - found), 0.0)


@lru_cache(maxsize=32)
def _net_of_modes(orders: tuple[tuple[int, int], ...], surface: Surface) -> np.ndarray:
    """The modes on the surface's net, shape (points, modes)."""
    x_m, y_m, _ = surface.net()
    half_x_m, half_y_m = surface.half_m
    return surface.modes_at(orders, x=x_m.ravel() / half_x_m, y=y_m.ravel() / half_y_m)
