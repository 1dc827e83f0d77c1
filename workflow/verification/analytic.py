"""Limits of the film equation that are known in closed form or by one linear solve.

Forces are means over a period in units of p0 times the finger's area; s is the amplitude profile
on the unit square. They share no code with the solver that they check.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from verification.marching import Amplitude
from verification.numpy_periodic import ChebyshevGrid, chebyshev_grid, real_eigenvectors

POINTS = 48


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
    values, vectors = real_eigenvectors(grid.second[1:-1, 1:-1])
    inverse = np.linalg.inv(vectors)
    modes = inverse @ right @ inverse.T / (values[:, None] + values + shift)
    return vectors @ modes @ vectors.T


def _with_rim(inner: NDArray[Any]) -> NDArray[Any]:
    return np.pad(inner, 1)
