"""Chebyshev collocation in space, SciPy's Radau in time, Anderson acceleration of the period.

Scheme: the mass H P at the inner Chebyshev points is the unknown; diffusion in the form
H^{3/2} (lap v - c v) with v = H^{3/2} (P^2 - 1)/2 (see `numpy_periodic`), exact dense
Jacobian, `solve_ivp` with Radau IIA (order 5) over one period, repeated from the Anderson
mix of earlier periods until the state repeats itself. Sides about which the profile is even
are folded. The mean force is integrated along as one more unknown.

Order: spectral in space; 5 in time, by tolerance. Cost: about a dozen periods at the paper's
squeeze numbers (more than 30 at 3e5); a period takes some dozens of factorisations of a dense
matrix of all points of the plane.
Source: Hairer and Wanner, Solving Ordinary Differential Equations II, 1996, IV.8 (Radau);
Trefethen, Spectral Methods in MATLAB, 2000.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

from squeezefilm.errors import RunError
from squeezefilm.film.scene import Scene
from squeezefilm_workflow.verification.marching import (
    FloatArray,
    film_symmetry_in_x_and_y,
    march_to_periodic_force,
)
from squeezefilm_workflow.verification.numpy_periodic import chebyshev_grid


def periodic_mean_force(scene: Scene, *, points: int = 12, rtol: float = 1e-6) -> float:
    """Mean force in p0 l0^2 of the period that repeats itself to rtol / 100.

    points: inner points along each half side, folded or not; rtol: Radau's
    relative tolerance (the absolute one is a tenth of it, on a mass of order 1).

    Raises RunError when Radau gives up.
    """
    epsilon, sigma = scene.epsilon, scene.sigma
    x_side, y_side = (_SquareSide(points, folded) for folded in film_symmetry_in_x_and_y(scene))
    s_edge = scene.amplitude(*np.meshgrid(x_side.grid.x, y_side.grid.x, indexing="ij"))
    x_matrix, y_matrix = x_side.grid.derivative_matrix, y_side.grid.derivative_matrix
    slope = (x_matrix @ s_edge) ** 2 + (s_edge @ y_matrix.T) ** 2
    bend = (
        x_side.grid.second_derivative_matrix @ s_edge
        + s_edge @ y_side.grid.second_derivative_matrix.T
    )
    kept = np.ix_(x_side.kept, y_side.kept)
    s, slope, bend = s_edge[kept].ravel(), slope[kept].ravel(), bend[kept].ravel()
    area = np.outer(x_side.weights, y_side.weights).ravel()
    plane = (x_side.kept.size, y_side.kept.size)
    laplacian = np.kron(x_side.second, np.eye(plane[1])) + np.kron(np.eye(plane[0]), y_side.second)

    def gap_and_curvature_term(t: float) -> tuple[FloatArray, FloatArray]:
        wave = epsilon * math.sin(t)
        gap = 1 + wave * s
        return gap, 1.5 * wave * bend / gap + 0.75 * wave**2 * slope / gap**2

    def state_rate(t: float, state: FloatArray) -> FloatArray:
        gap, c = gap_and_curvature_term(t)
        pressure = state[:-1] / gap
        scale = gap**1.5
        v = scale * (pressure**2 - 1) / 2
        v_plane = v.reshape(plane)
        lap = (x_side.second @ v_plane + v_plane @ y_side.second.T).ravel()
        return np.append(scale * (lap - c * v) / sigma, area @ (pressure - 1))

    def rate_jacobian(t: float, state: FloatArray) -> FloatArray:
        gap, c = gap_and_curvature_term(t)
        scale = gap**1.5
        to_v = state[:-1] / np.sqrt(gap)
        matrix = np.zeros((state.size, state.size))
        matrix[:-1, :-1] = (scale / sigma)[:, None] * laplacian * to_v
        matrix.flat[: -state.size : state.size + 1] -= scale * c * to_v / sigma
        matrix[-1, :-1] = area / gap
        return matrix

    def march_one_period(mass: FloatArray) -> tuple[FloatArray, float]:
        march = solve_ivp(
            state_rate,
            (0, 2 * math.pi),
            np.append(mass, 0.0),
            method="Radau",
            t_eval=[2 * math.pi],
            jac=rate_jacobian,
            rtol=rtol,
            atol=rtol / 10,
        )
        if not march.success:
            numbers = f"epsilon = {epsilon:g}, sigma = {sigma:g}"
            raise RunError(f"Chebyshev march: Radau stopped at {numbers}: {march.message}")
        return march.y[:-1, -1], float(march.y[-1, -1]) / (2 * math.pi)

    start, within = np.ones(s.size), rtol / 100
    return march_to_periodic_force(
        march_one_period, start, tolerance=within, periods=30, anderson_depth=10
    )


class _SquareSide:
    """One side of the square: its grid, the inner points kept, and their folded operators."""

    def __init__(self, points: int, folded: bool) -> None:
        self.grid, inner = chebyshev_grid(2 * points), np.eye(2 * points)
        if folded:  # an even field on all points
            inner = (inner + inner[::-1])[:, :points]
        self.kept = np.arange(1, inner.shape[1] + 1)
        self.second = self.grid.second_derivative_matrix[self.kept, 1:-1] @ inner
        self.weights = self.grid.weights[1:-1] @ inner
