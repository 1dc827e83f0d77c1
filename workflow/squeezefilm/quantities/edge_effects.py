"""Pressure on the film's edge: loss of gas that flows in, and flow around the edge.

    P = 1 − C (σ Re/24) ū_n²  where gas flows in (Bernoulli),  P = 1 where it flows out,

with the mean velocity ū over the gap, lengths by the pad's length along x, time by 1/ω. C is the
kinetic energy of a plug or of a parabola, over that of the mean velocity, and more with losses: it
is not known better than to the two. A wall that slides drags gas to the edge, with a pressure from
ρ U²/2 below to as much above the ambient one, which no film equation tells.

Gas that turns around the edge meets a resistance there, as if the film were 0.64 gaps longer
(Veijola, Pursula and Råback, J. Micromech. Microeng. 15, 2005: 1.3 for both sides), and the
inertia of gas outside:

    P = 1 + σ (h0/l) [0.64 ū_n/H + (0.097 + ln(R/h0)/(6π)) Re ∂(H ū_n)/∂T],

n outward. Both factors are those of a small oscillation (verification/edge_flow.py). At the
distance R the pressure is ambient: where the wave of sound that leaves the edge is no longer near,
or the pad's other sides are as near.

The edge's pressure and the film's state are solved for in turn, each with the other's last one,
until the force settles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.fields import Fields, apply_matrix_along_axis, dot, fold_even_columns
from squeezefilm.quantities.sheared_gas import wall_speed, wall_velocity
from squeezefilm.quantities.states import force_changes_and_errors, solve_perturbed_states
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.spectral import Axis, FluxPoints
from squeezefilm.reynolds.terms.rarefaction import (
    slip_coefficient_and_argument,
    slip_flow,
    slip_flow_derivatives,
)
from squeezefilm.solution import Solution

# Coefficients C of a plug and of a parabola.
EDGE_LOSS_COEFFICIENTS = (1.0, 1.54)
# Of flow around the edge: its resistance, its inertance without ln(R/h0)/(6π), and the distance R
# over that in which a wave of sound turns by 1. Errors of both, over them: of slow flow without
# slip, for each unit of Re and of Kn (`squeezefilm-verification edge-flow`).
EDGE_RESISTANCE, EDGE_INERTANCE, NEAR_WAVE_RATIO = 0.64, 0.097, 1.12
EDGE_RESISTANCE_ERROR, EDGE_INERTANCE_ERROR = (0.1, 0.15, 3.0), (0.2, 0.0, 3.0)
# Relative error of the force that an iteration of the state may leave.
STATE_FORCE_TOLERANCE = 1e-5
# Change of an effect, over a film's largest, at which the iteration ends; steps that it may take.
EFFECT_CHANGE_TOLERANCE, MAX_EDGE_ITERATIONS = 3e-3, 30
# Part of that which the next change may take, if expected by the fall of the last two.
CONVERGENCE_SAFETY_FACTOR = 5
# Pressures on the edge over the ambient one in whose effects higher orders do not count. At the
# first no state may be found of a film of large amplitude, at the second rounding counts more.
TRIAL_EDGE_PRESSURE_RATIOS = (1e-3, 1e-4)


def edge_effect_changes(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution],
    *,
    device: Device,
    loss_with_flow: bool = False,
) -> np.ndarray:
    """Return the relative changes of the forces by the pressure on the edge, and their errors.

    Args:
        solutions: of the scenes, with their states on two grids.
        loss_with_flow: the edge loss together with flow around the edge, and not alone.

    Returns:
        Changes and errors by the edge loss for each of EDGE_LOSS_COEFFICIENTS, by the resistance
        and by the inertance of flow around the edge, shape (2, 4, scenes); NaN where a solution has
        no states, or the iteration does not settle.
    """
    changes = force_changes_and_errors(
        scenes,
        solutions,
        partial(_edge_effect_changes_on_grid, device=device, loss_with_flow=loss_with_flow),
        changes=len(EDGE_LOSS_COEFFICIENTS) + 2,
        tolerance=STATE_FORCE_TOLERANCE,
    )
    changes[1] += EFFECT_CHANGE_TOLERANCE * np.abs(changes[0]).max(axis=0)
    return changes


def edge_inertance(scenes: Scenes | Scene) -> Any:
    """Return the inertance of flow around the edge, over Re: of gas as far as the sound is near."""
    gas, actuator = scenes.gas, scenes.actuator
    sound_m_per_s = np.sqrt(
        gas.heat_capacity_ratio * gas.ambient_pressure_pa / gas.density_kg_per_m3
    )
    near_m = NEAR_WAVE_RATIO * sound_m_per_s / actuator.angular_frequency_rad_per_s
    distance_m = np.minimum(near_m, np.minimum(scenes.pad.length_x_m, scenes.pad.length_y_m))
    return EDGE_INERTANCE + np.log(distance_m / scenes.h0_m) / (6 * np.pi)


def edge_flow_error_ratios(scene: Scene) -> np.ndarray:
    """Return the errors of the edge's resistance and of its inertance, over them, (2,)."""
    by = np.array([1.0, scene.modified_reynolds, scene.knudsen])
    return np.array([EDGE_RESISTANCE_ERROR, EDGE_INERTANCE_ERROR]) @ by


def ram_pressure_changes(
    scenes: Sequence[Scene], solutions: Sequence[Solution], *, device: Device
) -> np.ndarray:
    """Return what the pressure ρ U²/2 where a sliding wall drags gas in changes of the forces.

    Gas that comes in with the wall's speed and stops has it: the largest that there may be. The
    change goes with the pressure, and is solved for a small one.

    Args and returns: as of ``edge_effect_changes``, of one change, (2, 1, scenes).
    """

    def ram_pressure_change_on_grid(films: Fields, *, fraction: float) -> np.ndarray:
        square = squared_inflow_velocity(films, wall_velocity(films) / np.abs(wall_speed(films)))
        _, without = solve_with_edge_pressure(films, 0 * square, device=device)
        _, with_pressure = solve_with_edge_pressure(films, fraction * square, device=device)
        return np.array([with_pressure / without - 1])

    changes = np.full((2, 1, len(scenes)), np.nan)
    for fraction in TRIAL_EDGE_PRESSURE_RATIOS:
        if np.isnan(changes).any():
            of_grid = partial(ram_pressure_change_on_grid, fraction=fraction)
            tried = force_changes_and_errors(
                scenes, solutions, of_grid, changes=1, tolerance=STATE_FORCE_TOLERANCE
            )
            changes = np.where(np.isnan(changes), tried / fraction, changes)
    # ρ U²/2 over the ambient pressure.
    ram = [each.modified_reynolds * each.bearing_number**2 / (6 * each.sigma) for each in scenes]
    return changes * np.array(ram)


def _edge_effect_changes_on_grid(
    films: Fields, *, device: Device, loss_with_flow: bool
) -> np.ndarray:
    """Changes of the mean pressure over it on one grid, (4, scenes)."""
    count, copies = len(films.scenes), 3 + len(EDGE_LOSS_COEFFICIENTS)
    around = float(loss_with_flow)
    # Loss coefficient, and which parts of flow around the edge.
    effects = [
        (0.0, 0.0, 0.0),
        *((coefficient, around, around) for coefficient in EDGE_LOSS_COEFFICIENTS),
        (0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0),
    ]
    films = films.at(np.tile(np.arange(count), copies))
    loss, with_resistance, with_inertance = np.repeat(effects, count, axis=0).T
    laws = np.stack(
        [loss, EDGE_RESISTANCE * with_resistance, edge_inertance(films.scenes) * with_inertance]
    )
    change, difference = np.zeros(laws.shape[1]), np.zeros(laws.shape[1])
    step, moved = np.ones(laws.shape[1]), np.full(laws.shape[1], np.inf)
    for _ in range(MAX_EDGE_ITERATIONS):
        move = edge_pressure_of_flow(films, laws) - films.edge_gauge_pressure
        before, moved = moved, np.abs(move).max(axis=(1, 2, 3))
        # High harmonics of a large loss overshoot.
        step = np.where(moved > before, step / 4, step)
        edge = films.edge_gauge_pressure + step[:, None, None, None] * move
        tried, mean = solve_with_edge_pressure(films, edge, device=device)
        failed, without_loss = np.isnan(mean), np.tile(mean[:count], copies)
        last, change = change, np.where(failed, change, mean / without_loss - 1)
        earlier, difference = difference, np.abs(change - last)
        largest = np.abs(change).reshape(copies, count).max(axis=0)
        allowed = step * EFFECT_CHANGE_TOLERANCE * np.tile(largest, copies)
        # Or where the next difference, by the fall of the last two, is far below that.
        settled = ~failed & (
            (difference <= allowed / 2)
            | (difference**2 <= allowed / CONVERGENCE_SAFETY_FACTOR * earlier)
        )
        # Where Newton's method does not follow, a shorter step is tried.
        keep = failed[:, None, None, None]
        films = replace(
            films,
            edge_gauge_pressure=np.where(keep, films.edge_gauge_pressure, edge),
            unknowns=np.where(keep[..., None], films.unknowns, tried.unknowns),
        )
        step = np.where(failed, step / 2, np.minimum(1.5 * step, 1.0))
        if settled.all():
            break
    changes = np.where(settled, change, np.nan)
    return np.asarray(changes.reshape(copies, count)[1:])


def solve_with_edge_pressure(
    films: Fields, edge: np.ndarray, *, device: Device
) -> tuple[Fields, np.ndarray]:
    """Return states with a pressure on the edge, and their means, NaN where there is none."""
    films = replace(films, edge_gauge_pressure=edge)
    return solve_perturbed_states(
        films, edge_pressure_arrays(films), tolerance=STATE_FORCE_TOLERANCE, device=device
    )


def edge_pressure_of_flow(films: Fields, laws: np.ndarray) -> np.ndarray:
    """Return the pressure on the edge, P − 1, by the velocity of states that have some there.

    Args:
        laws: loss coefficient C, resistance and inertance of each scene, (3, scenes).
    """
    loss, resistance, inertance = laws[..., None, None, None]
    reynolds, length_x_m = films.scenes.modified_reynolds, films.scenes.pad.length_x_m
    reynolds, gap_over_length = (
        np.asarray(each)[:, None, None, None] for each in (reynolds, films.scenes.h0_m / length_x_m)
    )
    velocity = films.velocity_on_edge
    outflow = -dot(films.inward_normal_signs, velocity) / np.sqrt(films.area)
    around = resistance * outflow / films.gap
    around += inertance * reynolds * films.t_derivative(films.gap * outflow)
    inflow = squared_inflow_velocity(films, velocity)
    return np.asarray(films.sigma * (gap_over_length * around - loss * reynolds / 24 * inflow))


def squared_inflow_velocity(films: Fields, velocity: np.ndarray) -> np.ndarray:
    """Return the square of a velocity on the edge where it leads into the film, elsewhere 0."""
    inflow = np.maximum(films.inward_normal_signs * velocity, 0.0)
    return np.asarray(dot(inflow, inflow) / films.area)


def edge_pressure_arrays(films: Fields) -> dict[str, np.ndarray]:
    """Return what the pressure on the edge adds, by the names of terms/edge_pressure.py."""
    gap, flows = films.gap[films.inner], _edge_flow_potentials(films)
    powers = gap * np.sqrt(gap), gap  # np.power takes ten times longer
    added = {"edge_flow": np.zeros_like(gap)}
    for k, (axis, name) in enumerate(zip(films.axes_with_ends, "xy", strict=False)):
        values, slope, second = _node_to_flux_matrices(axis, films.axis_lengths[k])
        edge = films.edge_gauge_pressure[films.inner_slices_across(k)]
        added[f"edge_values_{name}"] = apply_matrix_along_axis(k, values, edge)
        added[f"edge_slope_{name}"] = apply_matrix_along_axis(k, slope, edge)
        for power, flow in zip(powers, flows, strict=False):
            added["edge_flow"] += power * apply_matrix_along_axis(
                k, second, flow[films.inner_slices_across(k)]
            )
    return added


@lru_cache(maxsize=64)
def _node_to_flux_matrices(axis: Axis, length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return matrices from all nodes to values and slopes at flux points, and divergences inside.

    Of functions that are even about the middle of a folded axis.
    """
    values = FluxPoints(axis).matrix_from_all_nodes
    slope = values @ axis.derivative_matrix / length
    second = (axis.divergence_matrix @ axis.derivative_matrix)[axis.inner_slice] / length**2
    return (
        fold_even_columns(values, axis),
        fold_even_columns(slope, axis),
        fold_even_columns(second, axis),
    )


def _edge_flow_potentials(films: Fields) -> list[np.ndarray]:
    """v of each flow term on the edge, c_k H^((3−k)/2) (g_k(P) − g_k(1)); inside it is 0."""
    gap, rise = films.gap, films.edge_gauge_pressure
    power, root = 1 + films.equation_numbers("inverse_exponent", absent=1.0), np.sqrt(gap)
    # Isothermal, (P² − 1)/2.
    potential = rise * (1 + rise / 2) if np.all(power == 2) else ((1 + rise) ** power - 1) / power
    flows = [gap * root * potential]
    if films.equation_number_table["flow"].shape[1] > 1:
        slip, inverse = slip_coefficient_and_argument(films.equation_number_table, gap)
        if inverse is None:
            flows.append(slip * gap * rise)
        else:  # to first order in the pressure, as flow_from splits the flow
            growth = slip_flow_derivatives(inverse)[0]
            flows[0] = flows[0] + root * slip * growth * rise
            flows.append(slip * gap * (slip_flow(inverse) - growth) * rise)
    return flows
