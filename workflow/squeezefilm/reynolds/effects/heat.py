"""Heat at first order: an isothermal film whose walls stay at ambient temperature.

Compression heats the gas by a = ∂P/∂T and friction by b = σ|ū|²/H², and conduction across the gap
takes it away. With β = ((γ − 1)/γ) Pr Re the gas is warmer by β H² (a/12 − b/20) of the ambient
temperature in the mean over the gap: so much less gas is in it, and the flow through it changes by
its density and viscosity. Beside slip its temperature jumps at the walls (terms/heat.py), and
compression warms it more by 6 jumps.
"""

from __future__ import annotations

import numpy as np

from squeezefilm.reynolds.effects.fields import Fields
from squeezefilm.reynolds.effects.sensitivity import Answers, total
from squeezefilm.reynolds.terms.heat import JUMP_WARMS


def change(
    films: Fields,
    answers: Answers,
    *,
    heating: np.ndarray,
    viscosity_exponent: np.ndarray,
    jump: np.ndarray,
) -> np.ndarray:
    """Change of the mean pressure, shape (scenes,).

    Args:
        heating: β of each scene.
        viscosity_exponent: κ of viscosity μ ~ temperature^κ.
        jump: of temperature at a wall over its slope there, times Hρ; 0 without slip.
    """
    sigma = films.problems.sigma
    # Times mass per area and H², with which go the flow that is lost and the gas that is missing.
    compression = films.mass * films.gap**2 * films.pressure_rate
    if np.any(jump):
        compression *= 1 + JUMP_WARMS * films.number(jump) / films.mass
    friction = films.mass * films.velocity.dot(films.velocity)  # over σ
    # Lighter gas, and more viscous.
    by_compression = 6 / 60 + viscosity_exponent * 3 / 60
    by_friction = 18 / 280 + viscosity_exponent * 3 / 140
    lost = answers.along * films.ease  # of a flow −σū
    slower = by_friction * sigma * total(lost, friction) - by_compression * total(lost, compression)
    missing = total(answers.rate, compression) / 12 - sigma * total(answers.rate, friction) / 20
    return sigma * heating * missing - heating * slower
