"""An infinite strip or a disc of film by Newton's method: a loss at its rim, a pad that moves.

A yardstick that shares nothing with the solver but the equation σ ∂(HP)/∂T = ∂(H³ P ∂P/∂x)/∂x:
Chebyshev nodes across the strip, of width 1, and an odd number of instants, all solved at once.
Of a disc they lie along its diameter, and its divergence is (1/r) ∂(r ·)/∂r.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from squeezefilm_workflow.verification.numpy_periodic import ChebyshevGrid, chebyshev_grid


@dataclass(frozen=True)
class PeriodicStrip:
    """H = 1 + ε s(x) sin T; of a disc s is even about its middle, 1/2."""

    epsilon: float
    sigma: float
    profile: Callable[[np.ndarray], np.ndarray]
    points: int = 24
    instant_count: int = 21
    disc: bool = False

    @cached_property
    def grid(self) -> ChebyshevGrid:
        return chebyshev_grid(self.points)

    @cached_property
    def divergence(self) -> np.ndarray:
        """∇· of a flow along x."""
        radius = self.grid.x[:, None] - 0.5
        return self.grid.derivative_matrix + np.eye(len(radius)) / radius * self.disc

    @cached_property
    def weights(self) -> np.ndarray:
        """Of the mean over the film: the mean over a disc of T_k(2r) is 1/(1 − k²/4) or 0."""
        if not self.disc:
            return self.grid.weights
        k = np.arange(len(self.grid.x))
        means = np.where(k % 4 == 0, 1 / (1 - k**2 / 4 + (k == 2)), 0.0)
        return np.linalg.solve(np.cos(np.outer(k, np.arccos(1 - 2 * self.grid.x))), means)

    @cached_property
    def gap(self) -> np.ndarray:
        """H, shape (nodes, instants)."""
        phase = 2 * np.pi * np.arange(self.instant_count) / self.instant_count
        return 1 + self.epsilon * self.profile(self.grid.x)[:, None] * np.sin(phase)

    @cached_property
    def time_derivative_matrix(self) -> np.ndarray:
        """∂/∂T on the instants."""
        apart = np.arange(self.instant_count)[:, None] - np.arange(self.instant_count)
        with np.errstate(divide="ignore"):
            matrix = 0.5 * (-1.0) ** apart / np.sin(np.pi * apart / self.instant_count)
        np.fill_diagonal(matrix, 0.0)
        return matrix

    def mean_overpressure(self, loss: float = 0.0) -> float:
        """Over p0, with P = 1 − loss (H² ∂P/∂x)² on the rim where gas streams in.

        Args:
            loss: C Re/(24 σ), as ū = −H² ∂P/∂x /σ.
        """
        return self._pad_mean(self._pressure(loss) - 1).real

    def stiffness(self, modulation: np.ndarray) -> np.ndarray:
        """Fall of the mean pressure per rise of the gap, as exp(iΩT), Ω in units of ω, (n,)."""
        return -self._moved(np.ones_like(self.gap), modulation)

    def gain(self, modulation: np.ndarray) -> np.ndarray:
        """Growth of the mean pressure per growth of ln ε, as exp(iΩT), likewise."""
        return self._moved(self.gap - 1, modulation)

    def _moved(self, gap_change: np.ndarray, modulation: np.ndarray) -> np.ndarray:
        """Change of the mean pressure by a small one of H that goes as exp(iΩT)."""
        across, pressure = self.grid.derivative_matrix, self._pressure(0.0)
        changes = []
        for omega in modulation:
            in_time = self.time_derivative_matrix + 1j * omega * np.eye(self.instant_count)
            driven = self.sigma * (pressure * gap_change) @ in_time.T
            flow = 3 * self.gap**2 * gap_change * pressure * (across @ pressure)
            driven -= self.divergence @ flow
            driven[[0, -1]] = 0.0
            changes.append(self._pad_mean(self._step(pressure, driven, in_time=in_time)))
        return np.array(changes)

    def _pad_mean(self, field: np.ndarray) -> complex:
        return complex(self.weights @ field.mean(axis=1))

    def _pressure(self, loss: float) -> np.ndarray:
        across, gap = self.grid.derivative_matrix, self.gap
        pressure = np.ones_like(gap)
        for _ in range(30):
            slope = across @ pressure
            residual = self.sigma * (pressure * gap) @ self.time_derivative_matrix.T
            residual -= self.divergence @ (gap**3 * pressure * slope)
            for end, inwards in ((0, -1.0), (-1, 1.0)):
                streams = np.maximum(inwards * gap[end] ** 2 * slope[end], 0.0)
                residual[end] = pressure[end] - 1 + loss * streams**2
            step = self._step(pressure, residual, in_time=self.time_derivative_matrix, loss=loss)
            pressure = pressure + step
            if np.abs(step).max() < 1e-9:
                return pressure
        raise ArithmeticError("the strip was not found")

    def _step(
        self, pressure: np.ndarray, residual: np.ndarray, *, in_time: np.ndarray, loss: float = 0.0
    ) -> np.ndarray:
        """Less the inverse of the linearised film times a residual."""
        across, gap = self.grid.derivative_matrix, self.gap
        (nodes, instants), each = gap.shape, np.arange(self.instant_count)
        slope = across @ pressure
        jacobian = np.zeros((nodes, instants, nodes, instants), dtype=in_time.dtype)
        jacobian[np.arange(nodes), :, np.arange(nodes)] = self.sigma * in_time * gap[:, None, :]
        flow = np.einsum("ij,tjk->tik", self.divergence, (gap**3 * pressure).T[:, :, None] * across)
        flow += self.divergence * (gap**3 * slope).T[:, None, :]
        for instant in each:
            jacobian[:, instant, :, instant] -= flow[instant]
        for end, inwards in ((0, -1.0), (nodes - 1, 1.0)):
            streams = np.maximum(inwards * gap[end] ** 2 * slope[end], 0.0)
            by_slope = 2 * loss * streams * inwards * gap[end] ** 2
            jacobian[end] = 0.0
            jacobian[end, each, :, each] = by_slope[:, None] * across[end]
            jacobian[end, each, end, each] += 1
        size = nodes * instants
        found = np.linalg.solve(jacobian.reshape(size, size), -residual.ravel())
        return np.asarray(found.reshape(nodes, instants))
