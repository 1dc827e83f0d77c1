"""The largest step of an explicit march in time, by experiment and by theory.

The classical Runge-Kutta method is stable for a decaying mode exp(-k T) while k dT <= 2.7853
(Hairer and Wanner, Solving Ordinary Differential Equations II, 1996, IV.2). The film's fastest
mode decays at k = |eigenvalue of the discrete Laplacian| (H^2 P) / sigma: the collocation points
near the rim, 1/n^2 apart, ask for steps of order sigma/n^4.
"""

import math
from dataclasses import dataclass

import numpy as np

from numerics.films import Film
from numerics.peers.numpy_periodic import chebyshev_grid
from numerics.peers.yardstick import FloatArray

RUNGE_KUTTA = 2.785293563405282  # root of x^3 - 4 x^2 + 12 x - 24 = 0
EPSILON = 1e-6  # so small that a mode may grow by GROWN and the film is linear still
GROWN = 1e3


@dataclass(frozen=True)
class StepLimit:
    """Least steps a period for a stable march, by experiment and by theory, at an epsilon."""

    epsilon: float
    experiment: float
    theory: float


def step_limit(*, sigma: float, points: int) -> StepLimit:
    """The limit on a Chebyshev grid of points x points for the centred sinc.

    The experiment marches a small film from a rough start and bisects on the step.
    """
    grid = chebyshev_grid(points)
    second = grid.second[1:-1, 1:-1]
    rate = 2 * float(np.abs(np.linalg.eigvals(second)).max()) / sigma
    theory = 2 * math.pi * rate / RUNGE_KUTTA
    film = Film("", EPSILON, sigma)
    s = film.amplitude(*np.meshgrid(grid.x, grid.x, indexing="ij"))
    lap_s = (grid.second @ s + s @ grid.second.T)[1:-1, 1:-1]
    slope = ((grid.first @ s) ** 2 + (s @ grid.first.T) ** 2)[1:-1, 1:-1]
    s = s[1:-1, 1:-1]
    start = EPSILON * np.random.default_rng(1).standard_normal(s.shape)

    def change(phase: float, mass: FloatArray) -> FloatArray:
        """d(HP)/dT from the rise of the mass, HP - 1, in the form of `numpy_periodic`."""
        wave = EPSILON * math.sin(phase)
        gap = 1 + wave * s
        p = (mass - wave * s) / gap
        v = gap**1.5 * p * (1 + p / 2)
        c = 1.5 * wave * lap_s / gap + 0.75 * wave**2 * slope / gap**2
        return gap**1.5 * (second @ v + v @ second.T - c * v) / sigma

    def stable(steps: float) -> bool:
        """Whether the march stays bounded over the time in which an unstable mode would grow."""
        step, mass, phase = 2 * math.pi / steps, start, 0.0
        for _ in range(400):
            k1 = change(phase, mass)
            k2 = change(phase + step / 2, mass + step / 2 * k1)
            k3 = change(phase + step / 2, mass + step / 2 * k2)
            k4 = change(phase + step, mass + step * k3)
            mass = mass + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            phase += step
            if not np.abs(mass).max() < GROWN * EPSILON:
                return False
        return True

    low, high = 0.5 * theory, 2 * theory
    while high / low > 1.005:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if stable(middle) else (middle, high)
    return StepLimit(EPSILON, high, theory)
