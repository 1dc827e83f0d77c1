"""The strip's film with velocity and temperature resolved across the gap.

The thin-film Navier-Stokes equations, with zeta = z/H across the gap and the pressure uniform over
it, u along the strip, r the density, theta the temperature in units of the ambient one:

    d(r H)/dT + d(r H u)/dX + d(r W)/dzeta = 0
    Re (r (du/dT + u du/dX) + r W/H du/dzeta) = -(12/sigma) dP/dX + d(mu du/dzeta)/dzeta / H^2
    Pr Re (r (dtheta/dT + u dtheta/dX) + r W/H dtheta/dzeta)
        = beta (dP/dT + u dP/dX + sigma/(12 H^2) mu (du/dzeta)^2) + d(mu dtheta/dzeta)/dzeta / H^2

with P = r theta, mu = theta^kappa the viscosity and, at a constant Prandtl number, the conductivity
too, and beta = (1 - 1/gamma) Pr Re. W is the flow across lines of constant zeta. At the walls
u = 0, theta = 1 and W = 0; on the rim P = 1. Without heat theta = 1 everywhere.

Gas enters over the rim with a profile that the film does not know. Two ways to do without one:

- "local": while gas streams in, the profile on the rim is the one that friction, pressure and the
  rate of change give it there. Along the strip velocity then changes as a parabola's would, and
  temperature does not change. Solved wherever it was tried, to Re = 20.
- "open": the profile continues the film inside smoothly, nothing is asked on the rim. Spectrally
  accurate while advection is weak, ill posed on fine grids where it is not.

How far the two are apart says how much the force depends on what is not known.

Unknowns: m = H P, J = r H u and theta. Then continuity is linear in J, and the coefficient in front
of both rates is H^2 P, which varies like the gap and not like its cube. Chebyshev points in both
directions, instants of a period; the integral of what a profile leaves over from its mean gives W.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from numerics.peers.yardstick import FloatArray
from numerics.strip.film import Gap, HeatedGas, StripFilm
from numerics.strip.grid import StripGrid
from numerics.strip.newton import Precondition, Root, Vector, newton

Entrance = Literal["local", "open"]


@dataclass(frozen=True)
class Fields:
    """The film at all points, walls and rim included.

    Attributes:
        mass: m, shape (instants, points across half of the strip, 1).
        flow: J, with the points across half of the gap on the last axis.
        temperature: theta, shape of the flow's.
    """

    mass: Vector
    flow: Vector
    temperature: Vector

    @property
    def density(self) -> Vector:
        """r H."""
        return self.mass / self.temperature

    @property
    def velocity(self) -> Vector:
        return self.flow / self.density


@dataclass(frozen=True)
class ResolvedFilm:
    """The equations on a grid.

    Attributes:
        gas: of which the temperature is resolved too; None for an isothermal film.
        entrance: what is said of gas that streams in over the rim.
    """

    film: StripFilm
    grid: StripGrid
    gas: HeatedGas | None = None
    entrance: Entrance = "local"

    @cached_property
    def gap(self) -> Gap:
        return Gap(self.film, self.grid)

    @cached_property
    def height(self) -> FloatArray:
        return self.gap.height[:, :, None]

    @property
    def conduction(self) -> float:
        """Pr Re."""
        return self.gas.prandtl * self.film.reynolds if self.gas else 0.0

    # State

    def packed(self, mass: Vector, flow: Vector, temperature: Vector) -> Vector:
        """What is unknown of the fields, temperature counted from the ambient one."""
        parts = [mass[:, 1:], flow[:, :, 1:], temperature[:, :, 1:]]
        return np.concatenate([part.ravel() for part in parts[: 3 if self.gas else 2]])

    def unpacked(self, state: Vector) -> tuple[Vector, Vector, Vector]:
        """The three fields with zeros on the rim and at the walls."""
        times, points, across = self.shape
        parts = np.split(state, np.cumsum([times * (points - 1), times * points * (across - 1)]))
        mass = np.zeros((times, points, 1), state.dtype)
        mass[:, 1:] = parts[0].reshape(times, points - 1, 1)
        flow, temperature = np.zeros((2, *self.shape), state.dtype)
        flow[:, :, 1:] = parts[1].reshape(times, points, across - 1)
        if self.gas:
            temperature[:, :, 1:] = parts[2].reshape(times, points, across - 1)
        return mass, flow, temperature

    def fields(self, state: Vector) -> Fields:
        mass, flow, warmth = self.unpacked(state)
        mass[:, 0] = self.height[:, 0]
        return Fields(mass, flow, 1 + warmth)

    @property
    def shape(self) -> tuple[int, int, int]:
        times, points = self.gap.height.shape
        return times, points, len(self.grid.zeta.x)

    def from_averaged(self, mass: FloatArray, flow: FloatArray) -> FloatArray:
        """The state of a parabola across the gap and of ambient temperature."""
        zeta = self.grid.zeta.x
        profile = flow[:, :, None] * 6 * zeta * (1 - zeta)
        return self.packed(mass[:, :, None], profile, np.zeros_like(profile))

    # Derivatives

    def rate(self, values: Vector) -> Vector:
        flat = values.reshape(len(values), -1)
        return (self.grid.rate @ flat).reshape(values.shape)

    def mean(self, values: Vector) -> Vector:
        """Over the gap, with that axis kept."""
        return (values @ self.grid.zeta.weights)[..., None]

    # Equations

    def residual(self, state: Vector) -> Vector:
        """Continuity; momentum times H m; energy times H^2."""
        grid, height, film = self.grid, self.height, self.film
        zeta = grid.zeta
        fields = self.fields(state)
        mass, flow, theta = fields.mass, fields.flow, fields.temperature
        gas, u = fields.density, fields.velocity
        pressure = mass / height
        slope = grid.x.even @ pressure
        viscosity = theta**self.gas.viscosity_exponent if self.gas else 1.0
        gathering = self.rate(gas) + grid.x.odd @ flow
        across = -gathering @ zeta.excess.T
        stretch, warming = self.along(fields)
        shear = u @ zeta.even.T
        friction = (viscosity * shear) @ zeta.odd.T
        carried = gas * self.rate(u) + flow * stretch + across * shear
        momentum = film.reynolds * height * carried + 12 / film.sigma * height**2 * slope - friction
        energy = np.zeros_like(flow)
        if self.gas:
            gradient = theta @ zeta.even.T
            kept = gas * self.rate(theta) + flow * warming + across * gradient
            work = height**2 * (self.rate(pressure) + u * slope)
            work = work + film.sigma / 12 * viscosity * shear**2
            conducted = (viscosity * gradient) @ zeta.odd.T
            energy = self.conduction * (height * kept - self.gas.compression * work) - conducted
        return self.packed(self.mean(gathering), mass * momentum, energy)

    def along(self, fields: Fields) -> tuple[Vector, Vector]:
        """du/dX and dtheta/dX.

        On the rim continuity is not among the equations, for the pressure is given; there its mean
        over the gap takes the place of the mean of what is differenced.
        """
        x, zeta = self.grid.x, self.grid.zeta.x
        u = fields.velocity
        stretch, warming = x.odd @ u, x.even @ fields.temperature
        load = self.mean(fields.density)
        mean = self.mean(fields.flow) / load
        wanted = (-self.rate(load) - mean * (x.even @ load))[:, :1] / load[:, :1]
        parabola = 6 * zeta * (1 - zeta)
        rim = stretch[:, :1]
        rim = rim + parabola * (wanted - self.mean(rim))
        if self.entrance == "local":
            inwards = u[:, :1].real > 0
            rim = np.where(inwards, parabola * wanted, rim)
            warming[:, :1] = np.where(inwards, 0, warming[:, :1])
        stretch[:, :1] = rim
        return stretch, warming

    def preconditioner(self, state: FloatArray) -> Precondition:
        """The equations without advection and linearised about the means over a period.

        For each harmonic the profiles of flow and temperature follow, through the eigenvectors of
        the second derivative across the gap, from the pressure, for which a matrix across the
        strip is left.
        """
        grid, film = self.grid, self.film
        x = grid.x
        inner = slice(1, None)
        decay, vectors = np.linalg.eig(-grid.zeta.second[inner, inner])
        decay, vectors = decay.real, vectors.real
        inverse = np.linalg.inv(vectors)
        mass = self.fields(state).mass.real
        content = (self.height * mass).mean(axis=0)
        harmonics = 1j * grid.harmonics[:, None, None]
        weights, ones = grid.zeta.weights[inner] @ vectors, inverse @ np.ones(len(decay))
        viscous = 1 / (decay + film.reynolds * harmonics * content)
        push = 12 / film.sigma * content
        conductance = push * (viscous * ones @ weights)[..., None]
        storage = harmonics + 0 * conductance
        beta = self.conduction * (self.gas.compression if self.gas else 0.0)
        thermal = 1 / (decay + self.conduction * harmonics * content)
        load = mass.mean(axis=0)
        if self.gas:
            expansion = beta * harmonics * (thermal * ones @ weights)[..., None]
            storage = storage * (1 - load * expansion)
        matrix = storage * np.eye(len(x.x)) - x.odd @ (conductance * x.even)
        schur = np.linalg.inv(matrix[:, inner, inner])

        def precondition(right: FloatArray) -> FloatArray:
            source, forced, heating = (np.fft.rfft(part, axis=0) for part in self.unpacked(right))
            forced = viscous * (forced[..., inner] @ inverse.T)
            heating = thermal * (heating[..., inner] @ inverse.T)
            source = source - x.odd @ (forced @ weights)[..., None]
            if self.gas:
                source = source + harmonics * load * (heating @ weights)[..., None]
            found = np.zeros_like(source)
            found[:, inner] = schur @ source[:, inner]
            flow = forced - viscous * ones * (push * (x.even @ found))
            warmth = heating + thermal * ones * (beta * harmonics * found)
            profiles = np.zeros((2, *flow.shape[:2], len(grid.zeta.x)), complex)
            profiles[..., inner] = np.stack([flow, warmth]) @ vectors.T
            back = [np.fft.irfft(part, n=grid.instants, axis=0) for part in (found, *profiles)]
            return self.packed(*back)

        return precondition

    def force(self, state: FloatArray) -> float:
        fields = self.fields(state)
        return self.gap.mean_overpressure((fields.mass / self.height)[..., 0])

    def solve(self, start: FloatArray, *, tolerance: float) -> Root:
        """The periodic state, from a state on the same grid."""
        return newton(self.residual, start, self.preconditioner, tolerance=tolerance)
