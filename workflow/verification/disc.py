"""A disc's film in the radius alone, with inertia and thermal effects, all instants at once.

It shares the equations with the solver (docs: inertia and thermal effects) and nothing
else. With s the square of the radius over the rim's, a pressure P and a velocity r v are smooth in
s, and

    r ∂/∂r = 2 s ∂/∂s,     ∇·(f r v) = 2 f v + 2 s ∂(f v)/∂s,     ∇P = 8 r ∂P/∂s,

the disc's diameter being 1: nothing is singular at the centre. Newton's matrix is dense, its
columns by complex steps.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import iv

from verification.numpy_periodic import ChebyshevGrid, chebyshev_grid

STEP, NEWTON_STEPS, ENOUGH = 1e-30, 30, 1e-11


@dataclass(frozen=True)
class Disc:
    """H = 1 + ε profile(r) sin T, r in diameters.

    Attributes:
        reynolds: Re = ρ0 ω h0²/μ of the inertia; 0 without.
        heating, conduction, exponent: ((γ − 1)/γ) Pr Re, Pr Re and κ of thermal effects; 0 without.
        loss: C Re σ/24 of the loss at the rim where gas comes in, P = 1 − loss u²; 0 without.
        points, instants: between centre and rim, and over the period, an odd number.
    """

    epsilon: float
    sigma: float
    reynolds: float = 0.0
    heating: float = 0.0
    conduction: float = 0.0
    exponent: float = 0.0
    loss: float = 0.0
    profile: Callable[[np.ndarray], np.ndarray] = np.ones_like
    points: int = 20
    instants: int = 17

    @cached_property
    def grid(self) -> ChebyshevGrid:
        return chebyshev_grid(self.points)

    def mean_pressure(self) -> np.ndarray:
        """P − 1 averaged over the disc, in p0, at each instant, shape (instants,).

        Raises:
            ArithmeticError: if Newton's method does not converge.
        """
        shape = 3, len(self.grid.x), self.instants
        state = np.zeros(shape)
        unit = 1j * STEP * np.eye(state.size).reshape(-1, *shape)
        for _ in range(NEWTON_STEPS):
            jacobian = self._residual(state + unit).imag.reshape(state.size, -1).T / STEP
            step = np.linalg.solve(jacobian, -self._residual(state).ravel()).reshape(shape)
            state = state + step * min(1.0, 0.5 / np.abs(step[0]).max())
            if np.abs(step[0]).max() < ENOUGH:
                return np.asarray(self.grid.weights @ state[0])
        raise ArithmeticError("Newton's method did not converge")

    def _residual(self, state: np.ndarray) -> np.ndarray:
        """Return the residuals of mass, momentum and energy, shape (…, 3, nodes, instants)."""
        s = self.grid.x[:, None]
        phase = 2 * np.pi * np.arange(self.instants) / self.instants
        waves = np.fft.rfft(np.eye(self.instants))
        in_time = np.fft.irfft(1j * np.arange(waves.shape[1]) * waves, n=self.instants)
        moved = self.epsilon * self.profile(np.sqrt(s) / 2)
        gap, gap_rate = 1 + moved * np.sin(phase), moved * np.cos(phase)

        def rate(field: np.ndarray) -> np.ndarray:
            return np.asarray(field @ in_time)

        excess, v, warm = np.moveaxis(state, -3, 0)
        pressure = 1 + excess
        lag = self.reynolds / 10 * pressure * gap**2
        filling = gap_rate / gap + rate(excess) / pressure
        carried = v * (v + 2 * s * (self.grid.first @ v))
        momentum = v + 8 * gap**2 / self.sigma * (self.grid.first @ excess)
        momentum += lag * (rate(v) + 9 / 7 * carried - v * filling / 7)
        cool = self.heating * self.sigma / 20 * s / 4 * v**2
        hot = warm - cool
        thermal = warm + self.conduction / 10 * pressure * gap**2 * rate(warm)
        thermal -= self.heating / 12 * gap**2 * rate(excess)
        beside = -v * (6 / 5 * warm - 9 / 14 * cool)
        beside -= v * self.exponent * (3 / 5 * warm - 3 / 7 * cool)
        beside += lag * (9 / 7 * hot * rate(v) + v * rate(hot) / 7)
        flow = pressure * gap * (v + beside)
        mass = rate(pressure * gap * (1 - hot)) + 2 * flow + 2 * s * (self.grid.first @ flow)
        inwards = np.where(v[..., -1, :].real < 0, v[..., -1, :] / 2, 0.0)
        mass[..., -1, :] = excess[..., -1, :] + self.loss * inwards**2
        return np.stack([mass, momentum, thermal], axis=-3)


def resolved_second_order(sigma: float, reynolds: float, *, points: int = 60) -> float:
    """Mean pressure over p0 ε² of a piston at ε → 0, the velocity resolved across the gap.

    With lengths across the gap by h0 and the first order p, u, w of isothermal gas, in e^(iT), the
    mean velocity u₂ of the second order obeys

        ∂²u₂/∂z² = (12/σ) ∂p₂/∂r + Re ⟨p ∂u/∂T + u ∂u/∂r + w ∂u/∂z⟩,     ∫u₂ dz + ⟨p ∫u dz⟩ = 0,

    u₂ = 0 at z = 0 and −⟨h ∂u/∂z⟩ at z = 1; no gas crosses a circle in the mean.
    """
    across, along = chebyshev_grid(points), chebyshev_grid(points)
    z, r, q = across.x, along.x[:, None] / 2, np.sqrt(1j * reynolds) / 2
    # u = −(12/σ) ∂p/∂r φ(z), and what ∫u dz has of that.
    turned = q * (2 * z - 1)
    phi = (1 - np.cosh(turned) / np.cosh(q)) / (1j * reynolds)
    slope = -2 * q * np.sinh(turned) / np.cosh(q) / (1j * reynolds)
    inside = (z - (np.sinh(turned) + np.sinh(q)) / (2 * q * np.cosh(q))) / (1j * reynolds)
    decay = np.sqrt(1j * sigma / (12 * inside[-1]))
    rim = iv(0, decay / 2)
    p = iv(0, decay * r) / rim - 1
    dp = decay * iv(1, decay * r) / rim
    u, rate = -12 / sigma * dp * phi, 1j * p
    divergence = -12 / sigma * decay**2 * (p + 1)
    curl = np.where(r > 0, dp / np.where(r > 0, r, 1), decay**2 / 2 / rim)
    du = -12 / sigma * (decay**2 * (p + 1) - curl) * phi
    w = -(rate * z + divergence * inside)

    def mean(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.real(a * np.conj(b)) / 2

    shear = -12 / sigma * dp * slope
    force = reynolds * (mean(p, 1j * u) + mean(u, du) + mean(w, shear))
    flow = -mean(np.ones(1), shear[:, -1]) / 2 - force @ (across.weights * z * (1 - z) / 2)
    flow += mean(p[:, 0], u @ across.weights)
    # ∫u₂ dz has −(1/σ) ∂p₂/∂r: the rest of it, and the mean over the disc by parts.
    return float(-4 * sigma * (along.weights / 2 * r[:, 0] ** 2) @ flow)
