"""Where the power goes that the surface puts into a resolved film, a balance it was not solved for.

Means over a period, in p0 omega h0 l0 per length of the strip. The surface does the work
-P dH/dT on the gas. Of an isothermal film that is friction and what gas carries off over the rim
as kinetic energy: the work of compression goes out as heat while the gas is compressed and comes
back as it expands, for ln P times continuity has the mean of P dH/dT. With heat it is what the
walls take up and what is carried off as enthalpy and kinetic energy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from numerics.peers.yardstick import FloatArray
from numerics.strip.resolved import ResolvedFilm


@dataclass(frozen=True)
class PowerBalance:
    """Powers of a film.

    Attributes:
        put_in: by the surface.
        friction: turned into heat by viscosity.
        walls: heat that the two walls take up; nan for an isothermal film.
        enthalpy, kinetic: carried off over both rims; no enthalpy in an isothermal film.
    """

    put_in: float
    friction: float
    walls: float
    enthalpy: float
    kinetic: float

    @property
    def defect(self) -> float:
        """What is missing of the power put in, relative."""
        sink = self.friction if np.isnan(self.walls) else self.walls + self.enthalpy
        return 1 - (sink + self.kinetic) / self.put_in


def power_balance(equation: ResolvedFilm, state: FloatArray) -> PowerBalance:
    """The balance of a periodic state."""
    film, grid, height = equation.film, equation.grid, equation.height
    fields = equation.fields(state)
    u, theta = fields.velocity, fields.temperature
    gas = equation.gas
    viscosity = theta**gas.viscosity_exponent if gas else 1.0

    def over_strip(values: FloatArray) -> float:
        """Of a quantity of shape (instants, points, 1)."""
        return float(grid.x.weights @ values[..., 0].mean(axis=0))

    def over_rims(values: FloatArray) -> float:
        """Carried outwards by the flow, at both rims."""
        return float(-2 * equation.mean(fields.flow * values)[:, 0].mean())

    dissipation = equation.mean(viscosity * (u @ grid.zeta.even.T) ** 2) / height
    walls, enthalpy = np.nan, 0.0
    if gas:
        gradient = (theta @ grid.zeta.even.T)[..., :1]
        walls = 2 * over_strip(gradient / height) / (gas.compression * equation.conduction)
        enthalpy = over_rims(theta - 1) / gas.compression
    return PowerBalance(
        put_in=over_strip(fields.mass / height * equation.gap.closing[..., None]),
        friction=film.sigma / 12 * over_strip(dissipation),
        walls=walls,
        enthalpy=enthalpy,
        kinetic=film.sigma * film.reynolds / 24 * over_rims(u**2),
    )
