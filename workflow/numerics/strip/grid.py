"""Half grids across a strip and across its gap, and the instants of a period.

A strip under a centred profile is even about its middle, and so is the gap between two walls at
rest and of one temperature: half of the points carry everything. Functions of either direction are
even or odd about the middle, each with a derivative of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from numerics.peers.numpy_periodic import chebyshev_grid
from numerics.peers.yardstick import FloatArray


@dataclass(frozen=True)
class HalfGrid:
    """One half of the Chebyshev points on [0, 1], from the end inwards.

    Attributes:
        x: the points in [0, 1/2), shape (n + 1,); the first is the end.
        even, odd: derivatives of functions even and odd about 1/2, shape (n + 1, n + 1).
        weights: of the mean of an even function, shape (n + 1,).
    """

    x: FloatArray
    even: FloatArray
    odd: FloatArray
    weights: FloatArray

    @cached_property
    def second(self) -> FloatArray:
        """Second derivative of an even function."""
        return self.odd @ self.even

    @cached_property
    def excess(self) -> FloatArray:
        """From an even function to the integral, from the end on, of its excess over its mean."""
        mean = np.outer(np.ones_like(self.weights), self.weights)
        return np.asarray(np.linalg.solve(self.odd, np.eye(len(mean)) - mean))


def half_grid(inner: int) -> HalfGrid:
    """The end and `inner` more points of a grid that has twice as many."""
    whole = chebyshev_grid(2 * inner)
    half = inner + 1
    near, far = whole.first[:half, :half], whole.first[:half, :inner:-1]
    return HalfGrid(
        x=whole.x[:half], even=near + far, odd=near - far, weights=2 * whole.weights[:half]
    )


@dataclass(frozen=True)
class StripGrid:
    """Points across half of the strip, across half of the gap, and instants of a period.

    Attributes:
        x: from the rim to the middle.
        zeta: from the wall to the middle of the gap, in units of the gap.
        instants: of a period, an odd number, so that each harmonic has its sine and its cosine.
    """

    x: HalfGrid
    zeta: HalfGrid
    instants: int

    @cached_property
    def phase(self) -> FloatArray:
        return np.asarray(2 * math.pi * np.arange(self.instants) / self.instants)

    @cached_property
    def rate(self) -> FloatArray:
        """Derivative of a periodic function of T, shape (instants, instants)."""
        n = self.instants
        lag = np.arange(n)[:, None] - np.arange(n)
        half = np.sin(math.pi * lag / n) + np.eye(n)
        return np.where(lag == 0, 0.0, 0.5 * (-1.0) ** lag / half)

    @cached_property
    def harmonics(self) -> FloatArray:
        """Numbers of the harmonics of a real function of T."""
        return np.arange(self.instants // 2 + 1.0)


def strip_grid(*, nx: int, nz: int, nt: int) -> StripGrid:
    """nx points across half of the strip beside the rim, nz across half of the gap beside the
    wall, nt instants (odd)."""
    if nt % 2 == 0:
        raise ValueError("an odd number of instants")
    return StripGrid(x=half_grid(nx), zeta=half_grid(nz), instants=nt)
