"""A strip whose rim takes its loss of pressure at every order, for what the first one misses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from numerics.peers.numpy_periodic import chebyshev_grid

Profile = Callable[[np.ndarray], np.ndarray]


def mean_overpressure(
    *,
    epsilon: float,
    sigma: float,
    profile: Profile,
    loss: float,
    points: int = 40,
    instants: int = 25,
) -> float:
    """Of an infinite strip of width 1, over p0: P = 1 − loss (H² ∂P/∂x)² where gas streams in.

    Newton's method on Chebyshev nodes across the strip and an odd number of instants.

    Args:
        loss: C Re/(24 σ), as ū = −H² ∂P/∂x /σ.
    """
    grid = chebyshev_grid(points)
    across, weights, nodes = grid.first, grid.weights, len(grid.x)
    phase = 2 * np.pi * np.arange(instants) / instants
    apart = np.arange(instants)[:, None] - np.arange(instants)
    with np.errstate(divide="ignore"):
        in_time = 0.5 * (-1.0) ** apart / np.sin(np.pi * apart / instants)
    np.fill_diagonal(in_time, 0.0)
    gap = 1 + epsilon * profile(grid.x)[:, None] * np.sin(phase)
    pressure = np.ones_like(gap)
    each = np.arange(instants)
    for _ in range(30):
        slope = across @ pressure
        residual = sigma * (pressure * gap) @ in_time.T - across @ (gap**3 * pressure * slope)
        jacobian = np.zeros((nodes, instants, nodes, instants))
        jacobian[np.arange(nodes), :, np.arange(nodes)] = sigma * in_time * gap[:, None, :]
        flow = np.einsum("ij,tjk->tik", across, (gap**3 * pressure).T[:, :, None] * across)
        flow += across * (gap**3 * slope).T[:, None, :]
        for instant in each:
            jacobian[:, instant, :, instant] -= flow[instant]
        for end, inwards in ((0, -1.0), (nodes - 1, 1.0)):
            streams = np.maximum(inwards * gap[end] ** 2 * slope[end], 0.0)
            residual[end] = pressure[end] - 1 + loss * streams**2
            jacobian[end] = 0.0
            by_slope = 2 * loss * streams * inwards * gap[end] ** 2
            jacobian[end, each, :, each] = by_slope[:, None] * across[end]
            jacobian[end, each, end, each] += 1
        size = nodes * instants
        step = np.linalg.solve(jacobian.reshape(size, size), -residual.ravel())
        pressure += step.reshape(pressure.shape)
        if np.abs(step).max() < 1e-9:
            return float(weights @ (pressure - 1).mean(axis=1))
    raise ArithmeticError("the strip was not found")
