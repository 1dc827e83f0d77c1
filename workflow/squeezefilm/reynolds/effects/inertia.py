"""Inertia of the gas at first order in the modified Reynolds number.

The velocity is taken as a parabola across the gap and the momentum equation is weighted with it,
as Ruyer-Quil and Manneville (Eur. Phys. J. B 15, 2000) do for a liquid film.
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
    v = films.velocity
    # Re ρ H²/10 with what slip makes of it, over Re/10.
    lag = films.gap * (films.mass + 4 * films.number(knudsen))
    rate = Vector(films.t_derivative(v.x), films.t_derivative(v.y))
    carried = Vector(
        v.dot(Vector(films.x_derivative(v.x, odd=True), films.y_derivative(v.x))),
        v.dot(Vector(films.x_derivative(v.y), films.y_derivative(v.y, odd=True))),
    )
    shortfall = total(answers.slope.dot(rate.plus(carried.times(9 / 7))), lag * films.mass)
    shortfall -= total(answers.slope.dot(v), lag * films.mass_rate) / 7
    return -films.problems.sigma * reynolds / 10 * shortfall
