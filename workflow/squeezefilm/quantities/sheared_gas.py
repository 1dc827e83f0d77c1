"""Inertia and heat of the gas that a sliding wall drags, beside those of the flow by pressure.

Across the gap (ζ = z/H, the sliding wall at 0) the film's velocity is, with the mean ū that
pressure drives and U = 2Λ/σ along the pad's x axis,

    u = U (1 − ζ) + 6 ū ζ (1 − ζ).

Momentum and energy, integrated twice across the gap from wall to wall, give the flux of mass m and
the mass per area μ that inertia and heat add at first order; they join the film equation
(film_over_period.cl) as − σ ∇·m − σ ∂μ/∂T. Those of ū alone are terms of the solver
(terms/inertia.py, terms/thermal.py). What U adds, with M = Hρ, b = σ/H² and β of terms/thermal.py:

    by inertia:  m = − (Re H M²/10) {½ (U·∇)ū − (1/14) ū (U·∇M)/M + (1/12) U (U·∇M)/M},
    by heat:     A = b (U²/12 − U·ū/2),   μ = − M β H² A/12,
                 m = − M β H² {U [(A + ∂P/∂T)/24 − b ū²/40 + (κ − 1) b U·ū/240]
                               + ū (1/10 + κ/20) A}.

The wall that slides may also vibrate: ζ follows both walls.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.fields import Fields, dot
from squeezefilm.quantities.states import changes_with_errors, solved_beside
from squeezefilm.reynolds.device import Device
from squeezefilm.solution import Solution

# Relative error of the force that an iteration of the state may leave.
STATE_TOLERANCE = 1e-6
# What first order misses, over its second order and the sizes of the effects, and the largest
# second order of which that is known (tests/numerics/data/sheared_strips.csv).
SECOND_ORDER_FACTOR, MOST_SECOND_ORDER = 0.3, 2.0


def mean_changes(
    scenes: Sequence[Scene], solutions: Sequence[Solution], *, device: Device
) -> np.ndarray:
    """Return the relative changes of the forces by inertia and heat of the dragged gas.

    Args:
        scenes: with inertia, thermal effects or both, whose gas has no flow factor.
        solutions: of the scenes, with their states on two grids.

    Returns:
        Changes and their errors by grids and iterations, shape (2, 1, scenes); NaN where a
        solution has no states or the state with the change is not found.
    """

    def on_grid(films: Fields) -> np.ndarray:
        source = mass_source(films)
        how: dict[str, Any] = {"tolerance": STATE_TOLERANCE, "device": device}
        _, without = solved_beside(films, {}, **how)
        _, with_source = solved_beside(films, {"edge_flow": source}, **how)
        return np.array([with_source / without - 1])

    return changes_with_errors(scenes, solutions, on_grid, changes=1, tolerance=STATE_TOLERANCE)


def remainder_of(scene: Scene, *, vibrating: float) -> float:
    """Return the bound of the second order over the sizes of the effects of inertia and heat.

    Args:
        vibrating: fraction of the effects that is not there in the same film without vibration.
    """
    widest = float(Scenes.of([scene]).static_gap_range[1][0]) ** 2
    return remainder(
        bearing=abs(scene.bearing_number),
        shear_reynolds=widest * scene.shear_reynolds,
        vibrating_reynolds=widest * scene.modified_reynolds * vibrating,
    )


def remainder(*, bearing: float, shear_reynolds: float, vibrating_reynolds: float) -> float:
    """Return what first order misses, over the sizes of the effects; NaN where it is unknown.

    A force is that of the steady film and what vibration adds. Second orders of both go with
    Re* (1 + |Λ|): Re* Λ is 6 ρ₀ U²/p₀, of a Mach number, as pressure falls along no more of the pad
    than 1/Λ of it. Those of what vibration adds go with Re too; a steady film has no ω.

    Args:
        bearing: |Λ|.
        shear_reynolds: Re* = ρ₀ |U| h²/(μ l) of the widest gap at rest.
        vibrating_reynolds: Re = ρ₀ ω h²/μ there, times the fraction of the effects that vibration
            adds.
    """
    second_order = shear_reynolds * (1 + bearing) + vibrating_reynolds * bearing / (1 + bearing)
    return SECOND_ORDER_FACTOR * second_order if second_order <= MOST_SECOND_ORDER else nan


def mass_source(films: Fields) -> np.ndarray:
    """Return what U adds to the film equation at the unknowns, − σ ∇·m − σ ∂μ/∂T."""
    flux, stored = added_by_sliding(films)
    rate = films.area * films.t_derivative(stored)
    return np.asarray((-films.sigma * (films.divergence(flux) + rate))[films.inner])


def added_by_sliding(films: Fields) -> tuple[np.ndarray, np.ndarray]:
    """Return the flux of mass, (2, scenes, x, y, t), and mass per area, (scenes, x, y, t)."""
    by_heat, stored = flux_and_mass_by_heat(films)
    return flux_by_inertia(films) + by_heat, stored


def flux_by_inertia(films: Fields) -> np.ndarray:
    """Return the flux that U adds by inertia; of slip only the longer lag."""
    v, wall, mass = films.velocity, wall_velocity(films), films.mass
    by_wall = films.carried(v + wall) - films.carried(v)  # (U·∇)ū, for U is uniform
    passed = wall_speed(films) * films.slide(mass) / films.area  # U·∇M
    shortfall = by_wall * mass / 2 + wall * (passed / 12) - v * (passed / 14)
    # Slip lengthens the lag as in terms/inertia.py.
    flow = films.equation["flow"]
    slip = flow[:, 1, None, None, None] / 1.5 if flow.shape[1] > 1 else 0.0
    return -films.numbers("lag", absent=0.0) * films.gap * (mass + slip) * shortfall


def flux_and_mass_by_heat(films: Fields) -> tuple[np.ndarray, np.ndarray]:
    """Return the flux and the mass per area that U adds by heat."""
    v, wall, square = films.velocity, wall_velocity(films), films.gap**2
    heating = films.numbers("heating", absent=0.0)
    exponent = films.numbers("viscosity_exponent", absent=0.0)
    jump = 1 + films.numbers("jump_warms", absent=0.0) / films.mass
    # Under an outline a product of two velocities is |dz/dζ|² times theirs.
    friction = films.sigma * dot(v, v) / films.area  # b ū² H²
    mixed = films.sigma * dot(v, wall) / films.area
    sheared = (films.sigma * wall_speed(films) ** 2 / 12 - mixed / 2) * jump
    warming = sheared + square * films.pressure_rate * jump
    with_wall = warming / 24 - friction / 40 + (exponent - 1) * mixed / 240
    lost = heating * films.mass
    flux = -lost * (wall * with_wall + v * ((1 / 10 + exponent / 20) * sheared))
    return flux, -lost * sheared / 12


def wall_speed(films: Fields) -> np.ndarray:
    """U = 2Λ/σ of the wall past the pad, a column."""
    return np.asarray(2 * films.numbers("bearing", absent=0.0) / films.sigma)


def wall_velocity(films: Fields) -> np.ndarray:
    """U as a vector field; under an outline along its coordinates, as ``Fields.slide``."""
    everywhere = wall_speed(films) * np.ones_like(films.gap)
    return np.stack([films.turn.real * everywhere, -films.turn.imag * everywhere])
