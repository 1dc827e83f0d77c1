"""A strip's film by its dimensionless numbers, and its gap on a grid.

Lengths along the strip by its width l0, across the gap by h0, time by 1/omega, pressure by p0,
velocities by omega l0. Re = rho0 omega h0^2 / mu, sigma = 12 mu omega l0^2 / (p0 h0^2); so
sigma Re = 12 rho0 omega^2 l0^2 / p0 is the actuator's alone, whatever the gap.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from numerics.peers.yardstick import FloatArray
from numerics.strip.grid import StripGrid

Profile = Callable[[FloatArray], FloatArray]
"""The amplitude profile s at distances from the middle, in units of the strip's width."""


def sinc_profile(distance: FloatArray) -> FloatArray:
    """The paper's profile under a strip of 1 cm, sinc(109.8 r) with sinc x = sin(pi x)/(pi x)."""
    return np.sinc(1.098 * distance)


@dataclass(frozen=True)
class HeatedGas:
    """What the temperature of a gas between walls at ambient temperature depends on.

    Attributes:
        prandtl: viscosity times heat capacity over conductivity, taken as constant.
        heat_capacity_ratio: at constant pressure over at constant volume.
        viscosity_exponent: of the power of temperature that viscosity, and so conductivity, is.
    """

    prandtl: float = 0.71
    heat_capacity_ratio: float = 1.4
    viscosity_exponent: float = 0.7

    @property
    def compression(self) -> float:
        """Share of a relative rise of pressure that appears as rise of temperature, adiabatic."""
        return 1 - 1 / self.heat_capacity_ratio


@dataclass(frozen=True)
class StripFilm:
    """Gas between a vibrating surface and an infinitely long strip.

    Attributes:
        epsilon: amplitude over mean gap, below 1.
        sigma, reynolds: squeeze number and modified Reynolds number.
        profile: even about the middle.
    """

    epsilon: float
    sigma: float
    reynolds: float
    profile: Profile = sinc_profile


@dataclass(frozen=True)
class Gap:
    """The gap H of a film on a grid, shape (instants, points across half of the strip)."""

    film: StripFilm
    grid: StripGrid

    @cached_property
    def height(self) -> FloatArray:
        s = self.film.profile(0.5 - self.grid.x.x)
        return 1 + self.film.epsilon * np.sin(self.grid.phase)[:, None] * s

    @cached_property
    def closing(self) -> FloatArray:
        """Minus the rate of the gap."""
        s = self.film.profile(0.5 - self.grid.x.x)
        return -self.film.epsilon * np.cos(self.grid.phase)[:, None] * s

    def mean_overpressure(self, pressure: FloatArray) -> float:
        """The mean force on the strip in p0 l0 per length, from P of the gap's shape."""
        return float(self.grid.x.weights @ (pressure - 1).mean(axis=0))
