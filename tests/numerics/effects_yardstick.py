"""What the Reynolds equation leaves out, again: another state, other forms, no adjoint.

The state is that of the NumPy solver of verification/, on the whole square; each effect is
solved for by itself with GMRES of SciPy; inertia is in the form that weighting the momentum
equation with z(H − z) gives, before mass conservation is used. Isothermal, viscous gas, unit
square, velocities and fluxes on the nodes with the rim. Notation as in the papers: P, H, m = Pū.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from verification.numpy_periodic import chebyshev_grid, periodic_state

Amplitude = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Numbers:
    """Dimensionless numbers of a film: Re = ρ0ωh0²/μ, Pr, γ, κ of viscosity, Kn of first order."""

    epsilon: float
    sigma: float
    reynolds: float
    prandtl: float = 0.71
    heat_capacity_ratio: float = 1.4
    viscosity_exponent: float = 0.7
    knudsen: float = 0.0


def effects(film: Numbers, amplitude: Amplitude, *, points: int, instants: int) -> dict[str, float]:
    """First order of each effect on the mean force in per cent; that of the rim for C = 1.

    Args:
        amplitude: s(x, y) on the unit square.
        points: inner Chebyshev points per side.
    """
    sigma, re = film.sigma, film.reynolds
    state = periodic_state(
        epsilon=film.epsilon,
        sigma=sigma,
        amplitude=amplitude,
        nx=points,
        ny=points,
        nt=instants,
        tolerance=1e-9,
    )
    line = chebyshev_grid(points)
    s = amplitude(*np.meshgrid(line.x, line.x, indexing="ij"))
    phase = 2 * np.pi * np.arange(instants)[:, None, None] / instants
    gap = 1 + film.epsilon * s * np.sin(phase)
    pressure = np.ones_like(gap)
    pressure[:, 1:-1, 1:-1] = state.pressure
    harmonics = 1j * np.arange(instants // 2 + 1)[:, None, None]
    harmonics[-1] = 0

    def d_t(f: np.ndarray) -> np.ndarray:
        return np.fft.irfft(harmonics * np.fft.rfft(f, axis=0), n=instants, axis=0)

    def d_x(f: np.ndarray) -> np.ndarray:
        return line.first @ f

    def d_y(f: np.ndarray) -> np.ndarray:
        return f @ line.first.T

    def divergence(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return d_x(x) + d_y(y)

    def flow(rise: np.ndarray) -> np.ndarray:
        return divergence(gap**3 * d_x(pressure * rise), gap**3 * d_y(pressure * rise))

    m_x, m_y = (-(gap**2) / sigma * pressure * d(pressure) for d in (d_x, d_y))

    def inertial(m: np.ndarray) -> np.ndarray:
        """I of one component of m."""
        across = (
            9
            / 35
            * gap**7
            * divergence(m_x * m / (pressure * gap**4), m_y * m / (pressure * gap**4))
        )
        rising = 6 / 5 * gap**2 / pressure * m * (m_x * d_x(gap) + m_y * d_y(gap))
        pushing = (
            -(gap**3) / 10 * d_t(pressure)
            - 3 / 10 * gap**4 * divergence(m_x / gap, m_y / gap)
            + 6 / 35 * gap**5 * divergence(m_x / gap**2, m_y / gap**2)
        )
        unsteady = gap**3 / 5 * d_t(m) + gap**2 / 10 * m * d_t(gap)
        return unsteady + across + rising + m / pressure * pushing

    u_x, u_y = m_x / pressure, m_y / pressure
    a, b = d_t(pressure), sigma * (u_x**2 + u_y**2) / gap**2
    beta = (1 - 1 / film.heat_capacity_ratio) * film.prandtl * re
    warmth = beta * gap**2 * (a / 12 - b / 20)
    slower = (
        -pressure
        * beta
        * gap**3
        * (6 * (a / 60 - 3 * b / 280) + 3 * film.viscosity_exponent * (a / 60 - b / 140))
    )
    rim = np.zeros_like(pressure)
    for side, inwards in (
        (np.s_[:, 0, 1:-1], u_x),
        (np.s_[:, -1, 1:-1], -u_x),
        (np.s_[:, 1:-1, 0], u_y),
        (np.s_[:, 1:-1, -1], -u_y),
    ):
        rim[side] = -sigma * re / 24 * np.clip(inwards[side], 0, None) ** 2
    sources = {
        "inertia": -sigma * re / 2 * divergence(pressure * inertial(m_x), pressure * inertial(m_y)),
        "heat": sigma * divergence(u_x * slower, u_y * slower)
        - sigma * d_t(gap * pressure * warmth),
        "slip": -6 * film.knudsen * divergence(gap**2 * d_x(pressure), gap**2 * d_y(pressure)),
        "rim": -flow(rim),
    }
    inside = np.s_[:, 1:-1, 1:-1]
    shape = gap[inside].shape
    diffusivity = float((gap**2 * pressure)[inside].mean())
    values, modes = np.linalg.eig(line.second[1:-1, 1:-1])
    values, modes = values.real, modes.real
    inverse = np.linalg.inv(modes)
    symbol = diffusivity * np.add.outer(values, values) - sigma * harmonics

    def precondition(f: np.ndarray) -> np.ndarray:
        modal = np.fft.rfft(inverse @ f.reshape(shape) @ inverse.T, axis=0) / symbol
        return (modes @ np.fft.irfft(modal, n=instants, axis=0) @ modes.T).ravel()

    def jacobian(w: np.ndarray) -> np.ndarray:
        mass = np.zeros_like(gap)
        mass[inside] = w.reshape(shape)
        return precondition((flow(mass / gap) - sigma * d_t(mass))[inside])

    operator = LinearOperator((gap[inside].size,) * 2, matvec=jacobian, dtype=float)
    weights = np.outer(line.weights, line.weights)
    percent = {}
    for name, source in sources.items():
        w, failed = gmres(operator, precondition(source[inside]), rtol=1e-7, restart=80)
        assert not failed, name
        change = rim.copy() if name == "rim" else np.zeros_like(gap)
        change[inside] += w.reshape(shape) / gap[inside]
        percent[name] = 100 * float(np.sum(weights * change.mean(axis=0))) / state.force
    return percent
