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

The stress on the wall at rest, the pad, is μU/h − (h/2) ∇p and less the moment of ρ Du/Dt with ζ
over the gap. Its mean over pad and period, where p is ambient on the edge, has by U beyond the
(3/5) ∮ρh ū ū·n of ū alone, in p₀ h₀/l₀,

    by inertia:  − (Re σ/12) {(1/5) M (U·∇)ū + (3/10) ū (U·∇M) + (1/30) U (U·∇H)},
    by heat:     κ {(σ/12) (U/H) θ + (β σ²/240) (U·ū) ū/H},
                 θ = β H² {(1/12) ∂P/∂T − b ū²/20 + A/12}.

With μ(θ) the wall that slides drags by its mean, ∇p by the part of θ that is odd about the middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.fields import Fields, dot
from squeezefilm.quantities.states import force_changes_and_errors, solve_perturbed_states
from squeezefilm.reynolds.device import Device
from squeezefilm.solution import Solution

# Relative error of the force that an iteration of the state may leave.
STATE_FORCE_TOLERANCE = 1e-6
# The same, where the quantity is a thrust, a small part of the force.
STATE_THRUST_TOLERANCE = 1e-8
# What first order misses, over its second order and the sizes of the effects, and the largest
# second order of which that is known (tests/numerics/data/sheared_strips.csv).
FIRST_ORDER_REMAINDER_FACTOR, MAX_KNOWN_SECOND_ORDER = 0.3, 2.0


def sheared_gas_force_changes(
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

    def sheared_gas_change_on_grid(films: Fields) -> np.ndarray:
        source = mass_source_of_sliding(films)
        how: dict[str, Any] = {"tolerance": STATE_FORCE_TOLERANCE, "device": device}
        _, without = solve_perturbed_states(films, {}, **how)
        _, with_source = solve_perturbed_states(films, {"edge_flow": source}, **how)
        return np.array([with_source / without - 1])

    return force_changes_and_errors(
        scenes, solutions, sheared_gas_change_on_grid, changes=1, tolerance=STATE_FORCE_TOLERANCE
    )


def scaled_sheared_gas_thrust(scene: Scene, solution: Solution, *, device: Device) -> np.ndarray:
    """Return what inertia and heat of the dragged gas add to the forces along the pad's x and y.

    Args:
        scene: with inertia, thermal effects or both, whose gas has no flow factor.
        solution: of the scene, with its states on two grids.

    Returns:
        Values and errors in p0 h0/l0 times the pad's area, shape (2, 2); NaN where the state with
        the dragged gas is not found or what first order misses is unknown.
    """
    in_y = np.array([1.0, solution.states[0].grid.fold_y == 0])

    def thrust_change_on_grid(own: Fields) -> np.ndarray:
        pressed = []
        for added in ({}, {"edge_flow": mass_source_of_sliding(own)}):
            films, means = solve_perturbed_states(
                own, added, tolerance=STATE_THRUST_TOLERANCE, device=device
            )
            # −(h/2) ∇p, and p on the pad's own slope; NaN where there is no state.
            by_slope = (films.static_gap_ratio - films.gap / 2) * films.slope
            pressed.append(by_slope + 0 * means[:, None, None, None])
        parts = (pressed[1] - pressed[0], *sliding_stress_on_pad(films))
        by_place = films.to_pad_axes(np.stack(parts, axis=1))
        by_part = films.mean(by_place)
        # Parts of a stress may cancel, and no less is missed of them.
        sizes = np.abs(by_part[:, 0]) + films.mean(np.abs(by_place[:, 1:])).sum(axis=1)
        return np.concatenate([by_part.sum(axis=1), sizes]) * np.tile(in_y, 2)[:, None]

    (values, errors) = force_changes_and_errors(
        [scene], [solution], thrust_change_on_grid, changes=4, tolerance=STATE_THRUST_TOLERANCE
    )[..., 0]
    missed = first_order_remainder_of_scene(scene, vibrating=1.0)
    missed += FIRST_ORDER_REMAINDER_FACTOR * _widest_gap_squared(scene) * scene.modified_reynolds
    missed += 6 * scene.slip_knudsen  # of the wall's velocity no slip is known
    return np.array([values[:2], in_y * errors[:2] + missed * values[2:]])


def sliding_stress_on_pad(films: Fields) -> tuple[np.ndarray, np.ndarray]:
    """Return what has the mean of the stress on the pad that U adds by inertia and by heat."""
    v, wall, mass = films.gap_mean_velocity, wall_velocity(films), films.mass
    by_wall = films.convective_acceleration(v + wall) - films.convective_acceleration(v)
    passed = wall_speed(films) * films.pad_x_derivative(mass) / films.area
    steepened = wall_speed(films) * films.pad_x_derivative(films.gap) / films.area
    shortfall = by_wall * mass / 5 + v * (0.3 * passed) + wall * (steepened / 30)
    by_inertia = -films.equation_numbers("reynolds", absent=0.0) * films.sigma / 12 * shortfall
    heating, square = films.equation_numbers("heating", absent=0.0), films.gap**2
    friction, mixed, sheared, jump = viscous_heating_terms(films)
    warm = (square * films.pressure_rate * jump + sheared) / 12 - friction / 20
    exponent = films.equation_numbers("viscosity_exponent", absent=0.0)
    thicker = exponent * heating * films.sigma / films.gap
    return by_inertia, thicker * (wall * (warm / 12) + v * (mixed / 240))


def first_order_remainder_of_scene(scene: Scene, *, vibrating: float) -> float:
    """Return the bound of the second order over the sizes of the effects of inertia and heat.

    Args:
        vibrating: fraction of the effects that is not there in the same film without vibration.
    """
    widest = _widest_gap_squared(scene)
    return first_order_remainder(
        bearing=abs(scene.bearing_number),
        shear_reynolds=widest * scene.shear_reynolds,
        vibrating_reynolds=widest * scene.modified_reynolds * vibrating,
    )


def _widest_gap_squared(scene: Scene) -> float:
    """Return the square of the widest gap at rest over h0."""
    return float(Scenes.of([scene]).static_gap_ratio_range[1][0]) ** 2


def first_order_remainder(
    *, bearing: float, shear_reynolds: float, vibrating_reynolds: float
) -> float:
    """Return what first order misses, over the sizes of the effects; NaN where it is unknown.

    A force is that of the steady film and what vibration adds. Second orders of both go with
    Re* (1 + |Λ|): Re* Λ is 6 ρ₀ U²/p₀, of a Mach number, as pressure falls along no more of the pad
    than 1/Λ of it. Those of what vibration adds go with Re too; a steady film has no ω.

    Args:
        bearing: |Λ|.
        shear_reynolds: Re* = ρ₀ |U| h²/(μ l0) of the widest gap at rest.
        vibrating_reynolds: Re = ρ₀ ω h²/μ there, times the fraction of the effects that vibration
            adds.
    """
    second_order = shear_reynolds * (1 + bearing) + vibrating_reynolds * bearing / (1 + bearing)
    return (
        FIRST_ORDER_REMAINDER_FACTOR * second_order
        if second_order <= MAX_KNOWN_SECOND_ORDER
        else nan
    )


def mass_source_of_sliding(films: Fields) -> np.ndarray:
    """Return what U adds to the film equation at the unknowns, − σ ∇·m − σ ∂μ/∂T."""
    flux, stored = sliding_flux_and_mass(films)
    rate = films.area * films.t_derivative(stored)
    return np.asarray((-films.sigma * (films.divergence(flux) + rate))[films.inner])


def sliding_flux_and_mass(films: Fields) -> tuple[np.ndarray, np.ndarray]:
    """Return the flux of mass, (2, scenes, x, y, t), and mass per area, (scenes, x, y, t)."""
    by_heat, stored = flux_and_mass_by_heating(films)
    return sliding_flux_by_inertia(films) + by_heat, stored


def sliding_flux_by_inertia(films: Fields) -> np.ndarray:
    """Return the flux that U adds by inertia; of slip only the longer lag."""
    v, wall, mass = films.gap_mean_velocity, wall_velocity(films), films.mass
    # (U·∇)ū, for U is uniform.
    by_wall = films.convective_acceleration(v + wall) - films.convective_acceleration(v)
    passed = wall_speed(films) * films.pad_x_derivative(mass) / films.area  # U·∇M
    shortfall = by_wall * mass / 2 + wall * (passed / 12) - v * (passed / 14)
    # Slip lengthens the lag as in terms/inertia.py.
    flow = films.equation_number_table["flow"]
    slip = flow[:, 1, None, None, None] / 1.5 if flow.shape[1] > 1 else 0.0
    return -films.equation_numbers("lag", absent=0.0) * films.gap * (mass + slip) * shortfall


def flux_and_mass_by_heating(films: Fields) -> tuple[np.ndarray, np.ndarray]:
    """Return the flux and the mass per area that U adds by heat."""
    v, wall, square = films.gap_mean_velocity, wall_velocity(films), films.gap**2
    heating = films.equation_numbers("heating", absent=0.0)
    exponent = films.equation_numbers("viscosity_exponent", absent=0.0)
    friction, mixed, sheared, jump = viscous_heating_terms(films)
    warming = sheared + square * films.pressure_rate * jump
    with_wall = warming / 24 - friction / 40 + (exponent - 1) * mixed / 240
    lost = heating * films.mass
    flux = -lost * (wall * with_wall + v * ((1 / 10 + exponent / 20) * sheared))
    return flux, -lost * sheared / 12


def viscous_heating_terms(films: Fields) -> tuple[np.ndarray, ...]:
    """Return b ū² H², b U·ū H², A H² and the factor by which a jump at the walls warms more."""
    v, wall = films.gap_mean_velocity, wall_velocity(films)
    jump = 1 + films.equation_numbers("jump_warms", absent=0.0) / films.mass
    # Under an outline a product of two velocities is |dz/dζ|² times theirs.
    friction, mixed = (films.sigma * dot(v, other) / films.area for other in (v, wall))
    sheared = (films.sigma * wall_speed(films) ** 2 / 12 - mixed / 2) * jump
    return friction, mixed, sheared, jump


def wall_speed(films: Fields) -> np.ndarray:
    """U = 2Λ/σ of the wall past the pad, a column."""
    return np.asarray(2 * films.equation_numbers("bearing", absent=0.0) / films.sigma)


def wall_velocity(films: Fields) -> np.ndarray:
    """U as a vector field; under an outline along its coordinates, as
    ``Fields.pad_x_derivative``."""
    everywhere = wall_speed(films) * np.ones_like(films.gap)
    return np.stack(
        [films.conformal_map_slope.real * everywhere, -films.conformal_map_slope.imag * everywhere]
    )
