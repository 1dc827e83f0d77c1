"""Inertia and heat of gas whose velocity is a wall's, that slides, and a parabola by pressure.

Across the gap (ζ = z/H, the sliding wall at 0) the film's velocity is, with the mean ū that
pressure drives and U = 2Λ/σ along the pad's x axis,

    u = U (1 − ζ) + 6 ū ζ (1 − ζ).

Momentum and energy, integrated twice across the gap from wall to wall, give what inertia and heat
change at first order, at the film's own pressure: the flux of mass m and the mass per area μ, which
join the film equation (film_over_period.cl) as − σ ∇·m − σ ∂μ/∂T. At U = 0 they are those of a pad
at rest. The wall that slides may also vibrate: ζ follows both walls.

Not used by the error budget yet: what the first order misses is known too little. In 90 strips
with resolved profiles (sheared_strip.py) it was at most SHEAR_REMAINDER times ``shear`` of the sum
of both effects' sizes where their nodes resolve the layer at the inlet in which gas warms; both
numbers were chosen after these strips, and 17 more had no state.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from host_film import Fields, dot

from squeezefilm.film.scene import OperatingPoints

SHEAR_REMAINDER, KNOWN_SHEAR = 0.15, 2.0


@dataclass(frozen=True)
class Change:
    """Mass and its flux that an effect adds to the film.

    Attributes:
        flux: of mass, m, shape (2, scenes, x, y, t), as ``Fields.velocity`` times Hρ.
        stored: mass per area, shape (scenes, x, y, t), of the ambient density times h0.
    """

    flux: np.ndarray
    stored: np.ndarray

    def residual(self, films: Fields) -> np.ndarray:
        """Return its part of the film equation, − σ ∇·m − σ ∂μ/∂T, at the unknowns.

        The mass w by which the film answers has J w = − this.
        """
        rate = films.area * films.t_derivative(self.stored)
        return np.asarray((-films.sigma * (films.divergence(self.flux) + rate))[films.inner])


def by_inertia(films: Fields, reynolds: np.ndarray, *, knudsen: np.ndarray | float = 0.0) -> Change:
    """Change by inertia at first order in Re.

    With M = Hρ the mean velocity falls short of that of the film by

        (Re ρ H²/10) {∂ū/∂T + (9/7) (ū·∇)ū + ½ (U·∇)ū − (1/7) ū (∂M/∂T + ½ U·∇M)/M
                      + (1/12) U (U·∇M)/M}.

    Args:
        reynolds: Re = ρ₀ ω h₀²/μ, as a column (``Fields.number``).
        knudsen: with slip the lag's factor is 1 + 4 Kn/M; of U no slip is known.
    """
    v, wall, mass = films.velocity, wall_velocity(films), films.mass
    rate = np.stack([films.t_derivative(v[0]), films.t_derivative(v[1])])
    own = films.carried(v)
    by_wall = films.carried(v + wall) - own  # (U·∇)ū, for U is uniform
    passed = wall_speed(films) * films.slide(mass) / films.area  # U·∇M
    mass_rate = films.t_derivative(mass) + passed / 2
    # Times M², with the lag Re H (M + 4 Kn)/10 of it.
    shortfall = (rate + 9 / 7 * own + by_wall / 2) * mass
    shortfall += wall * (passed / 12) - v * (mass_rate / 7)
    lag = reynolds / 10 * films.gap * (mass + 4 * knudsen)
    return Change(-lag * shortfall, np.zeros_like(mass))


def by_heat(
    films: Fields,
    heating: np.ndarray,
    exponent: np.ndarray | float,
    *,
    jump_warms: np.ndarray | float = 0.0,
) -> Change:
    """Change by heat of a film between walls of ambient temperature, at first order in β.

    Gas is heated by A = ∂P/∂T + (σ/H²) (U²/12 − U·ū/2), evenly across the gap, and by the rest of
    u·∇P and of friction, which is not even. With b = σ/H² its mean rise, of the ambient
    temperature, is β H² (A/12 − b ū²/20); it moves

        m = − M β H² { U [A/24 − b ū²/40 + (κ − 1) b U·ū/240]
                       + ū [(1/10 + κ/20) A − (9/140 + 3κ/140) b ū²] }.

    Args:
        heating: β = ((γ − 1)/γ) Pr Re, as a column (``Fields.number``).
        exponent: κ of viscosity, which grows with temperature to this power.
        jump_warms: what a jump of temperature at the walls adds to the mean rise by A, as a share.
    """
    v, wall, square = films.velocity, wall_velocity(films), films.gap**2
    # Under an outline a product of two velocities is |dz/dζ|² times theirs.
    by_pressure, mixed = dot(v, v) / films.area, dot(v, wall) / films.area
    friction = films.sigma * by_pressure  # b ū² H²
    sheared = films.sigma * mixed
    even = square * films.pressure_rate
    even += films.sigma * (wall_speed(films) ** 2 / 12 - mixed / 2)
    even = even * (1 + jump_warms)
    rise = even / 12 - friction / 20
    with_wall = rise / 2 + (exponent - 1) * sheared / 240
    with_parabola = (1 / 10 + exponent / 20) * even - (9 + 3 * exponent) / 140 * friction
    lost = heating * films.mass
    return Change(-lost * (wall * with_wall + v * with_parabola), -lost * rise)


def shear(scene: OperatingPoints) -> Any:
    """Re* (1 + |Λ|), with the shear Reynolds number Re* = ρ₀ |U| h₀²/(μ l) of the sliding wall.

    Re* Λ is 6 ρ₀ U²/p₀, of a Mach number: pressure falls along no more of the pad than 1/Λ of it.
    """
    bearing = abs(scene.bearing_number)
    return scene.modified_reynolds * 2 * bearing / scene.sigma * (1 + bearing)


def wall_speed(films: Fields) -> np.ndarray:
    """U = 2Λ/σ of the wall past the pad, a column."""
    return np.asarray(2 * films.numbers("bearing", absent=0.0) / films.sigma)


def wall_velocity(films: Fields) -> np.ndarray:
    """U as a vector field; under an outline along its coordinates, as ``Fields.slide``."""
    speed, everywhere = wall_speed(films), np.ones_like(films.gap)
    if films.grid.outline is None:
        return np.stack([speed * everywhere, 0 * everywhere])
    return np.stack([films.turn.real * speed * everywhere, -films.turn.imag * speed * everywhere])
