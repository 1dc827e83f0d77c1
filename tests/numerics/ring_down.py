"""A mass on a disc of film, integrated in time until its oscillation has died away.

Method of lines: along the radius r of a disc of diameter 1, without thermal effects,

    ∂(HP)/∂T + (1/r) ∂(r HPu)/∂r = 0,    H = 1 + δ + ε s(r) sin T,    P = 1 at the edge,
    u + (Re/10) PH² (∂u/∂T + (9/7) u ∂u/∂r − (1/7) u ∂ln(HP)/∂T) = −(H²/σ) ∂P/∂r,
    d²δ/dT² = scale (⟨P − 1⟩ − load),

⟨·⟩ the mean over the disc and ``scale`` p0 times its area over h0, over mass and ω². Functions of r
have Chebyshev nodes along the diameter, by parity; the implicit steps are LSODA's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import ceil, pi

import numpy as np
from scipy.integrate import odeint

from squeezefilm_workflow.verification.marching import FloatArray
from squeezefilm_workflow.verification.numpy_periodic import chebyshev_grid

# Of the steps in time, relative and absolute.
STEP_TOLERANCE = 1e-8
# Instants in a period: their mean is free of the vibration.
INSTANTS = 16
# Decay times of the film's slowest mode until it is settled; its rate is 4 j₀₁² over σ.
SETTLING, SLOWEST_RATE = 10, 23.13
# Velocity of the mass as it is let go, over √scale: so much of the gap it then moves, about.
KICK = 3e-4
# Periods after the release in which the film's faster modes die away.
SKIPPED_PERIODS = 2
# Motions that are told from each other: a damped oscillation and modes of the film.
MOTIONS = 5


@dataclass(frozen=True)
class RingDown:
    """A disc of film of excursion ratio ε and squeeze number σ, by its diameter.

    Attributes:
        profile: s at radii r, from 0 to 1/2.
        reynolds: modified Reynolds number Re; 0 for a film without inertia.
        points: nodes inside along the radius.
    """

    epsilon: float
    sigma: float
    profile: Callable[[FloatArray], FloatArray]
    reynolds: float = 0.0
    points: int = 12

    @cached_property
    def radius(self) -> FloatArray:
        """Radii of the nodes, the edge last, shape (points + 1,)."""
        return np.asarray(chebyshev_grid(2 * self.points).x[self.points + 1 :] - 0.5)

    @cached_property
    def s(self) -> FloatArray:
        """The profile on the nodes."""
        return self.profile(self.radius)

    @cached_property
    def derivatives(self) -> tuple[FloatArray, FloatArray]:
        """∂/∂r of an even function and of an odd one, on the nodes."""
        first, half = chebyshev_grid(2 * self.points).derivative_matrix, self.points + 1
        near, far = first[half:, half:], first[half:, half - 1 :: -1]
        return near + far, near - far

    @cached_property
    def weights(self) -> FloatArray:
        """Weights of the mean over the disc, exact for even polynomials of r."""
        k = np.arange(len(self.radius))
        scaled = np.cos(np.outer(2 * k, np.arccos(2 * self.radius)))
        # The mean of T_2k(2r): 1/(1 − k²) for even k, else 0.
        means = np.where(k % 2 == 0, 1 / (1.0 - k**2 + (k == 1)), 0.0)
        return np.asarray(np.linalg.solve(scaled, means))

    def decay(self, *, scale: float, periods: int = 40) -> tuple[float, float]:
        """Frequency in units of the vibration's and damping ratio of the free oscillation.

        The gap is held until the film has settled, with the load as its mean force.

        Args:
            scale: see above.
            periods: after the mass was let go.
        """
        settling = ceil(SETTLING * self.sigma / SLOWEST_RATE / (2 * pi))
        held, start = self._moved(self._at_rest(), settling, scale=0.0, load=0.0)
        forces = self._force(held[-INSTANTS:], 2 * pi * np.arange(1, INSTANTS + 1) / INSTANTS)
        start[-2:] += self._vibration_of_mass(forces, scale)
        start[-1] += KICK * scale**0.5
        states, _ = self._moved(start, periods, scale=scale, load=float(forces.mean()))
        gap = np.convolve(states[:, -2], np.full(INSTANTS, 1 / INSTANTS), mode="valid")
        gap = gap[SKIPPED_PERIODS * INSTANTS :]
        # Prony's method: motions exp(sT) about a new rest obey δ(T + m t) = Σ a_k δ(T + k t) + c.
        step, count = INSTANTS // 2, len(gap) - MOTIONS * INSTANTS // 2
        shifted = [gap[k * step : k * step + count] for k in range(MOTIONS)]
        columns = np.stack([*shifted, np.ones(count)], axis=1)
        ahead = np.linalg.lstsq(columns, gap[MOTIONS * step :])[0][:MOTIONS]
        factors = np.roots([1, *-ahead[::-1]])
        factor = complex(max(factors[factors.imag > 0], key=abs))
        rate = np.log(factor) / (2 * pi * step / INSTANTS)
        return float(rate.imag), float(-rate.real / abs(rate))

    @staticmethod
    def _vibration_of_mass(forces: FloatArray, scale: float) -> FloatArray:
        """δ and dδ/dT at T = 0 of a mass that moves with the vibration alone.

        Args:
            forces: on the pad at INSTANTS of a period, T = 0 the last.
        """
        harmonics = np.arange(1, INSTANTS // 2)
        waves = 2 * scale * np.fft.rfft(np.roll(forces, 1))[1:-1] / INSTANTS
        return np.array([(-waves / harmonics**2).real.sum(), (waves / (1j * harmonics)).real.sum()])

    def _at_rest(self) -> FloatArray:
        """HP inside, u with inertia, δ and dδ/dT of a film at rest."""
        still = np.zeros((self.points + 1) * (self.reynolds > 0) + 2)
        return np.append(np.ones(self.points), still)

    def _gap(self, state: FloatArray, time: FloatArray | float) -> FloatArray:
        motion = self.epsilon * np.multiply.outer(np.sin(time), self.s)
        return np.asarray(1 + state[..., -2:-1] + motion)

    def _pressure(self, state: FloatArray, time: FloatArray | float) -> FloatArray:
        inside = state[..., : self.points] / self._gap(state, time)[..., :-1]
        return np.concatenate([inside, np.ones((*inside.shape[:-1], 1))], axis=-1)

    def _force(self, state: FloatArray, time: FloatArray | float) -> FloatArray:
        return np.asarray((self._pressure(state, time) - 1) @ self.weights)

    def _moved(
        self, start: FloatArray, periods: int, *, scale: float, load: float
    ) -> tuple[FloatArray, FloatArray]:
        """States at INSTANTS in each period after ``start``, and the last one."""
        of_even, of_odd = self.derivatives
        divergence = of_odd + np.diag(1 / self.radius)

        def rate(time: float, state: FloatArray) -> FloatArray:
            gap, pressure = self._gap(state, time), self._pressure(state, time)
            mass, viscous = gap * pressure, -(gap**2) * (of_even @ pressure) / self.sigma
            velocity = state[self.points : -2] if self.reynolds else viscous
            mass_rate = -divergence @ (mass * velocity)
            mass_rate[-1] = state[-1] + self.epsilon * self.s[-1] * np.cos(time)
            velocity_rate = np.empty(0)
            if self.reynolds:
                lag = self.reynolds / 10 * mass * gap
                convection = -9 / 7 * (of_odd @ velocity) + mass_rate / mass / 7
                velocity_rate = (viscous - velocity) / lag + velocity * convection
            push = scale * (float(self._force(state, time)) - load)
            return np.concatenate([mass_rate[:-1], velocity_rate, [state[-1], push]])

        times = np.linspace(0, 2 * pi * periods, periods * INSTANTS + 1)
        states = odeint(
            rate,
            start,
            times,
            tfirst=True,
            rtol=STEP_TOLERANCE,
            atol=STEP_TOLERANCE / 100,
            mxstep=10_000,
        )
        return states[1:], states[-1]
