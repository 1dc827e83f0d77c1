"""Limits of the film equation that are known in closed form or by one linear solve.

Forces are means over a period in units of p0 times the finger's area; s is the amplitude profile
on the unit square. They share no code with the solver that they check.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from numerics.peers.numpy_periodic import ChebyshevGrid, chebyshev_grid
from numerics.peers.yardstick import Amplitude

POINTS = 48
PISTON_SLOW = 0.00170251052  # S / sigma^2 of the square piston for sigma -> 0


def blech_stiffness(*, sigma: float, aspect: float = 1.0, terms: int = 4000) -> float:
    """Spring coefficient S of a rectangular piston (Blech 1983), in units of p0 area / h0.

    The double series over odd m, n with the one over n, of the side along y, summed in closed
    form by tanh, which leaves a single series over m that is complete to rounding.
    """
    m = np.arange(1, 2 * terms, 2)
    # sum over odd n of 8/(pi^2 n^2) sigma^2/((pi^2 (m^2 + n^2/aspect^2))^2 + sigma^2)
    # = -Im of the mean over y of the solution of p'' - (pi^2 m^2 + i sigma) p = i sigma.
    root = np.sqrt((math.pi * m) ** 2 + 1j * sigma)
    half = root * aspect / 2
    mean = 1j * sigma / root**2 * (np.tanh(half) / half - 1)
    return float(np.sum(8 / (math.pi * m) ** 2 * -mean.real))


def piston_small_amplitude(*, epsilon: float, sigma: float, aspect: float = 1.0) -> float:
    """(5/4) epsilon^2 S, with a relative error of order epsilon^2."""
    return 1.25 * epsilon**2 * blech_stiffness(sigma=sigma, aspect=aspect)


def piston_slow(*, epsilon: float, sigma: float) -> float:
    """(5/2) sigma^2 <H'^2/H^6> S2 for sigma -> 0, all epsilon; square finger."""
    phase = 2 * math.pi * np.arange(4096) / 4096
    rate = (epsilon * np.cos(phase)) ** 2 / (1 + epsilon * np.sin(phase)) ** 6
    return float(2.5 * sigma**2 * rate.mean() * PISTON_SLOW)


def small_amplitude(*, epsilon: float, sigma: float, amplitude: Amplitude) -> float:
    """Second order in epsilon for any s on the unit square, by two linear solves.

    lap q - i sigma q = i sigma s, then lap v = -(3/2) div(s grad Re q), both zero on the rim;
    F = epsilon^2 integral of v - |q|^2/4. The relative error is of order epsilon^2.
    """
    grid = chebyshev_grid(_points(sigma))
    s = amplitude(*np.meshgrid(grid.x, grid.x, indexing="ij"))
    q = _with_rim(_solve(grid, 1j * sigma * s[1:-1, 1:-1], shift=-1j * sigma))
    real = np.real(q)
    flux_x, flux_y = s * (grid.first @ real), s * (real @ grid.first.T)
    source = -1.5 * (grid.first @ flux_x + flux_y @ grid.first.T)
    v = _with_rim(_solve(grid, source[1:-1, 1:-1]))
    mean = np.real(v) - np.abs(q) ** 2 / 4
    return float(epsilon**2 * grid.weights @ mean @ grid.weights)


def fast(*, epsilon: float, amplitude: Amplitude, knudsen: float = 0.0) -> float:
    """The limit sigma -> infinity for any s and epsilon, by one Laplace solve.

    HP tends to psi(X, Y) with g = psi^2/2 + 6 Kn psi harmonic and, on the rim,
    g = (1 + 3/2 epsilon^2 s^2)/2 + 6 Kn (1 + epsilon^2 s^2/2). The relative error is of order
    1/sqrt(sigma).
    """
    grid = chebyshev_grid(POINTS)
    s = amplitude(*np.meshgrid(grid.x, grid.x, indexing="ij"))
    square = (epsilon * s) ** 2
    g = (1 + 1.5 * square) / 2 + 6 * knudsen * (1 + square / 2)
    g[1:-1, 1:-1] = 0
    second = grid.second
    source = -(second @ g + g @ second.T)[1:-1, 1:-1]
    g[1:-1, 1:-1] = np.real(_solve(grid, source))
    psi = np.sqrt((6 * knudsen) ** 2 + 2 * g) - 6 * knudsen
    overpressure = psi / np.sqrt(1 - square) - 1
    return float(grid.weights @ overpressure @ grid.weights)


def _points(sigma: float) -> int:
    """Enough for a layer of width sqrt(2/sigma)."""
    return min(max(POINTS, int(6 * sigma**0.25)), 240)


def _solve(grid: ChebyshevGrid, right: NDArray[Any], *, shift: complex = 0.0) -> NDArray[Any]:
    """Solve (lap + shift) u = right at the inner points, u zero on the rim."""
    values, vectors = np.linalg.eig(grid.second[1:-1, 1:-1])
    values, vectors = values.real, vectors.real
    inverse = np.linalg.inv(vectors)
    modes = inverse @ right @ inverse.T / (values[:, None] + values + shift)
    return vectors @ modes @ vectors.T


def _with_rim(inner: NDArray[Any]) -> NDArray[Any]:
    return np.pad(inner, 1)
