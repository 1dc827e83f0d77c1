"""The strip's film with one mode of velocity and one of temperature across the gap.

To the unknowns of the averaged film comes the rise of temperature by compression, averaged over the
gap, in units of the ambient temperature; with beta = compression Pr Re and the mean velocity u of
the isothermal momentum equation

    rise + (Pr Re P H^2 / 10) d(rise)/dT = (beta H^2 / 12) dP/dT,     warmth = rise - cooling,
    cooling = beta sigma u^2 / 20,

the latter what expansion along the strip takes more than friction gives.

The gap holds m (1 - warmth), and beside J = m u flows m times

    -u (6/5 rise - 9/14 cooling + kappa (3/5 rise - 3/7 cooling))
        + (Re P H^2 / 10) (9/7 warmth du/dT + u d(warmth)/dT / 7).

That heat is carried along the strip, and that its temperature weakens conduction, is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from numerics.peers.yardstick import FloatArray
from numerics.strip.averaged import AveragedFilm
from numerics.strip.film import HeatedGas
from numerics.strip.newton import Precondition, Root, Vector, newton


@dataclass(frozen=True)
class HeatedFilm:
    """The equations on the grid of an averaged film, whose inertia they have or not."""

    averaged: AveragedFilm
    gas: HeatedGas

    @property
    def conduction(self) -> float:
        """Pr Re; of a film without inertia too, where Re stands for its gas."""
        return self.gas.prandtl * self.averaged.film.reynolds

    @cached_property
    def shape(self) -> tuple[int, int]:
        rows, columns = self.averaged.gap.height.shape
        return rows, columns

    def packed(self, averaged: Vector, rise: Vector) -> Vector:
        return np.concatenate([averaged, rise.ravel()])

    def unpacked(self, state: Vector) -> tuple[Vector, Vector]:
        """The averaged film's state and the rise by compression at all points."""
        averaged, rise = np.split(state, [-self.shape[0] * self.shape[1]])
        return averaged, rise.reshape(self.shape)

    def residual(self, state: Vector) -> Vector:
        film, gas, grid = self.averaged, self.gas, self.averaged.grid
        height, sigma = film.gap.height, film.film.sigma
        averaged, rise = self.unpacked(state)
        mass, flow = film.unpacked(averaged)
        pressure, u = mass / height, flow / mass
        beta = gas.compression * self.conduction
        cooling = beta * sigma * u**2 / 20
        warmth = rise - cooling
        swelling = grid.rate @ warmth
        beside = -u * (6 / 5 * rise - 9 / 14 * cooling)
        beside = beside - u * gas.viscosity_exponent * (3 / 5 * rise - 3 / 7 * cooling)
        lag = film.reynolds / 10 * height * mass
        beside = beside + lag * (9 / 7 * warmth * (grid.rate @ u) + u * swelling / 7)
        continuity = -(grid.rate @ (mass * warmth)) + (mass * beside) @ grid.x.odd.T
        # Continuity, which has taken the place of du/dX there, has more.
        momentum = -lag * 9 / 7 * u * continuity
        conducted = rise + self.conduction / 10 * height * mass * (grid.rate @ rise)
        compressed = beta * height**2 / 12 * (grid.rate @ pressure)
        extra = film.packed(continuity, momentum)
        return self.packed(film.residual(averaged) + extra, conducted - compressed)

    def preconditioner(self, state: FloatArray) -> Precondition:
        """That of the averaged film, and the lag of the temperature."""
        film, grid = self.averaged, self.averaged.grid
        averaged, _ = self.unpacked(state)
        mass, _ = film.unpacked(averaged)
        lag = self.conduction / 10 * (film.gap.height * mass).mean(axis=0)
        follows = 1 / (1 + 1j * grid.harmonics[:, None] * lag)
        isothermal = film.preconditioner(averaged)

        def precondition(right: FloatArray) -> FloatArray:
            of_film, rise = self.unpacked(right)
            spectrum = follows * np.fft.rfft(rise, axis=0)
            rise = np.fft.irfft(spectrum, n=grid.instants, axis=0)
            return self.packed(isothermal(of_film), rise)

        return precondition

    def force(self, state: FloatArray) -> float:
        return self.averaged.force(self.unpacked(state)[0])

    def solve(self, start: FloatArray, *, tolerance: float) -> Root:
        """The periodic state, from one of the averaged film."""
        first = self.packed(start, np.zeros(self.shape))
        return newton(self.residual, first, self.preconditioner, tolerance=tolerance)
