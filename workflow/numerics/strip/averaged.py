"""The strip's film averaged over the gap: Reynolds, first order in Re, one mode, first-order heat.

Unknowns are the gas under a point of the strip, m = H P, and the flow J = m u of its mean velocity
u, which obey

    dm/dT + dJ/dX = 0,     P = 1 on the rim,
    u + (Re P H^2 / 10) (du/dT - u ((10/7) d(ln m)/dT + (9/7) u d(ln m)/dX)) = -(H^2 / sigma) dP/dX.

The second equation is the momentum of a parabola across the gap, weighted with that parabola:
friction and pressure are exact, and so is the force to first order in Re. Continuity took the place
of du/dX, so that it holds on the rim too, where the pressure is given instead. Re = 0 is the
Reynolds equation. Chebyshev points across the strip, instants of a period, Newton's method.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from numerics.peers.yardstick import FloatArray
from numerics.strip.film import Gap, HeatedGas, StripFilm
from numerics.strip.grid import StripGrid
from numerics.strip.newton import Precondition, Root, Vector, newton, solve_linear

LINEAR_TOLERANCE = 1e-9
"""Of the linear solves behind first-order effects, relative."""


@dataclass(frozen=True)
class AveragedFilm:
    """The equations on a grid.

    Attributes:
        film: gives sigma, the gap and, where it counts, Re.
        grid: across the strip and in time; that across the gap is not used.
        inertia: whether the terms with Re are there.
    """

    film: StripFilm
    grid: StripGrid
    inertia: bool

    @cached_property
    def gap(self) -> Gap:
        return Gap(self.film, self.grid)

    @property
    def reynolds(self) -> float:
        return self.film.reynolds if self.inertia else 0.0

    @cached_property
    def at_rest(self) -> FloatArray:
        """Ambient pressure and no flow."""
        height = self.gap.height
        return self.packed(height, np.zeros_like(height))

    def packed(self, mass: Vector, flow: Vector) -> Vector:
        return np.concatenate([mass[:, 1:].ravel(), flow.ravel()])

    def unpacked(self, state: Vector) -> tuple[Vector, Vector]:
        """m and J at all points, shape of the gap's; m on the rim is the gap."""
        rows, columns = self.gap.height.shape
        inner, flow = np.split(state, [rows * (columns - 1)])
        mass = self.gap.height.astype(state.dtype)
        mass[:, 1:] = inner.reshape(rows, columns - 1)
        return mass, flow.reshape(rows, columns)

    def residual(self, state: Vector) -> Vector:
        """Continuity inside, and momentum times m everywhere."""
        return self.still(state) + self.reynolds * self.inertial(state)

    def still(self, state: Vector) -> Vector:
        """What is left of the residual at Re = 0."""
        grid, height = self.grid, self.gap.height
        mass, flow = self.unpacked(state)
        continuity = grid.rate @ mass + flow @ grid.x.odd.T
        slope = (mass / height) @ grid.x.even.T
        return self.packed(continuity, flow + height**2 * mass * slope / self.film.sigma)

    def inertial(self, state: Vector) -> Vector:
        """The residual's derivative by Re."""
        grid, height = self.grid, self.gap.height
        mass, flow = self.unpacked(state)
        u = flow / mass
        spreading = 10 * (grid.rate @ mass) + 9 * u * (mass @ grid.x.even.T)
        acceleration = mass * (grid.rate @ u) - u * spreading / 7
        return self.packed(np.zeros_like(mass), height * mass * acceleration / 10)

    def preconditioner(self, state: FloatArray) -> Precondition:
        """The equations linearised about the means over a period, solved for each harmonic."""
        grid, shape = self.grid, self.gap.height.shape
        mass, _ = self.unpacked(state)
        mobility = (self.gap.height * mass).mean(axis=0)
        harmonics = 1j * grid.harmonics[:, None]
        response = 1 / (1 + self.reynolds * harmonics * mobility / 10)
        conductance = response * mobility / self.film.sigma
        storage = harmonics[:, :, None] * np.eye(shape[1])
        inner = slice(1, None)
        inverse = np.linalg.inv(
            (storage - grid.x.odd @ (conductance[:, :, None] * grid.x.even))[:, inner, inner]
        )

        def precondition(right: FloatArray) -> FloatArray:
            continuity, momentum = self.unpacked(right)
            source = np.fft.rfft(continuity, axis=0)
            forced = response * np.fft.rfft(momentum, axis=0)
            found = np.zeros_like(source)
            found[:, inner] = (inverse @ (source - forced @ grid.x.odd.T)[:, inner, None])[..., 0]
            flow = forced - conductance * (found @ grid.x.even.T)
            return self.packed(
                np.fft.irfft(found, n=grid.instants, axis=0),
                np.fft.irfft(flow, n=grid.instants, axis=0),
            )

        return precondition

    def force(self, state: FloatArray) -> float:
        mass, _ = self.unpacked(state)
        return self.gap.mean_overpressure(mass / self.gap.height)

    def solve(self, *, tolerance: float, start: FloatArray | None = None) -> Root:
        """The periodic state, from ambient pressure or from another state on the same grid."""
        first = self.at_rest if start is None else start
        return newton(self.residual, first, self.preconditioner, tolerance=tolerance)

    def response(self, state: FloatArray, right: FloatArray) -> float:
        """Change of the force when the residual at a solution changes by `right`."""
        change, _ = solve_linear(
            self.residual, state, -right, self.preconditioner(state), tolerance=LINEAR_TOLERANCE
        )
        mass, _ = self.unpacked(change)
        mass[:, 0] = 0  # the rim's gas is the gap's, whatever happens inside
        over = mass / self.gap.height
        return float(self.grid.x.weights @ over.mean(axis=0))


def heat_source(equation: AveragedFilm, state: FloatArray, gas: HeatedGas) -> FloatArray:
    """What heat adds to the residual, to first order in beta = compression Pr Re.

    Between walls at ambient temperature, about the isothermal state: with a = dP/dT and
    b = sigma u^2 / H^2 the mean rise of temperature is beta H^2 (a/12 - b/20), which thins the gas,
    and the rise near the middle of the gap changes the flow by its density and its viscosity.
    """
    grid, height = equation.grid, equation.gap.height
    mass, flow = equation.unpacked(state)
    pressure, u = mass / height, flow / mass
    beta = gas.compression * gas.prandtl * equation.film.reynolds
    a, b = grid.rate @ pressure, equation.film.sigma * u**2 / height**2
    warmth = beta * height**2 * (a / 12 - b / 20)
    lighter = 6 * (a / 60 - 3 * b / 280)
    stiffer = 3 * gas.viscosity_exponent * (a / 60 - b / 140)
    extra = -flow * beta * height**2 * (lighter + stiffer)
    continuity = -(grid.rate @ (mass * warmth)) + extra @ grid.x.odd.T
    return equation.packed(continuity, np.zeros_like(flow))
