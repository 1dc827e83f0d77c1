"""Inertia of the gas at first order in the modified Reynolds number (physics.md, T10).

The velocity is taken as a parabola across the gap and the momentum equation is weighted with it.
With the mean velocity ū and the velocity V that pressure alone would drive this reads

    ū + (Re ρ H²/10) {∂ū/∂T + (9/7)(ū·∇)ū − (1/7) ū ∂/∂T ln(Hρ)} = V,

so that to first order the velocity falls short of V by the second term at ū = V.
"""

from __future__ import annotations

import numpy as np

from squeezefilm.reynolds.effects.fields import Fields, Vector


def source(films: Fields, *, reynolds: np.ndarray, knudsen: np.ndarray) -> np.ndarray:
    """Source of mass on all nodes: −σ times the divergence of the flow that inertia adds.

    Args:
        reynolds: modified Reynolds number of each scene, at ambient density.
        knudsen: Knudsen number of each scene with slip, 0 without.
    """
    short = shortfall(films)
    slip = 1 + 4 * films.number(knudsen) / films.mass
    factor = -films.sigma * films.number(reynolds) / 10 * slip * films.mass * films.density
    return films.divergence(short.times(factor * films.gap**2))


def shortfall(films: Fields) -> Vector:
    """∂V/∂T + (9/7)(V·∇)V − (1/7) V ∂/∂T ln(Hρ)."""
    v = films.velocity
    thinning = films.t_derivative(np.log(films.mass))
    carried_x = v.x * films.x_derivative(v.x, odd=True) + v.y * films.y_derivative(v.x)
    carried_y = v.x * films.x_derivative(v.y) + v.y * films.y_derivative(v.y, odd=True)
    return Vector(
        films.t_derivative(v.x) + 9 / 7 * carried_x - thinning * v.x / 7,
        films.t_derivative(v.y) + 9 / 7 * carried_y - thinning * v.y / 7,
    )
