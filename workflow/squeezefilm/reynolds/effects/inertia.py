"""Inertia of the gas at first order in the modified Reynolds number (physics.md, T10).

The velocity is taken as a parabola across the gap and the momentum equation is weighted with it.
With the mean velocity ū and the velocity V that pressure alone would drive this reads

    ū + (Re ρ H²/10) {∂ū/∂T + (9/7)(ū·∇)ū − (1/7) ū ∂/∂T ln(Hρ)} = V,

so that to first order the velocity falls short of V by the second term at ū = V.
"""

from __future__ import annotations

import numpy as np

from squeezefilm.reynolds.effects.fields import Fields, Vector
from squeezefilm.reynolds.effects.sensitivity import Answers, total


def change(
    films: Fields, answers: Answers, *, reynolds: np.ndarray, knudsen: np.ndarray
) -> np.ndarray:
    """Change of the mean pressure, shape (scenes,): its source is −σ∇· of the flow that is added.

    Args:
        reynolds: modified Reynolds number of each scene, at ambient density.
        knudsen: Knudsen number of each scene with slip, 0 without.
    """
    # Re ρ H²/10 with what slip makes of it, times the mass.
    factor = films.mass * (films.mass + 4 * films.number(knudsen)) * films.gap
    strength = -films.problems.sigma * reynolds / 10
    return strength * total(answers.along(shortfall(films)), factor)


def shortfall(films: Fields) -> Vector:
    """∂V/∂T + (9/7)(V·∇)V − (1/7) V ∂/∂T ln(Hρ)."""
    v = films.velocity
    thinning = films.gap_rate / films.gap
    thinning += films.density_slope * films.pressure_rate / films.density
    carried_x = v.x * films.x_derivative(v.x, odd=True) + v.y * films.y_derivative(v.x)
    carried_y = v.x * films.x_derivative(v.y) + v.y * films.y_derivative(v.y, odd=True)
    return Vector(
        films.t_derivative(v.x) + 9 / 7 * carried_x - thinning * v.x / 7,
        films.t_derivative(v.y) + 9 / 7 * carried_y - thinning * v.y / 7,
    )
