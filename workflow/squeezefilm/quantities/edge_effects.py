"""Pressure on the film's edge: loss of gas that flows in, and flow around the edge.

    P = 1 − C (σ Re/24) ū_n²  where gas flows in (Bernoulli),  P = 1 where it flows out,

with the mean velocity ū over the gap, lengths by the pad's length along x, time by 1/ω. C is the
kinetic energy of a plug or of a parabola, over that of the mean velocity, and more with losses: it
is not known better than to the two. A wall that slides drags gas to the edge, with a pressure from
ρ U²/2 below to as much above the ambient one, which no film equation tells.

Gas that turns around the edge meets a resistance there, as if the film were 0.64 gaps longer
(Veijola, Pursula and Råback, J. Micromech. Microeng. 15, 2005: 1.3 for both sides), and the
inertia of gas outside:

    P = 1 + σ (h0/l0) [0.64 ū_n/H + (0.097 + ln(R/h0)/(6π)) Re ∂(H ū_n)/∂T],

n outward. Both factors are those of a small oscillation (verification/edge_flow.py). At the
distance R the pressure is ambient: where the wave of sound that leaves the edge is no longer near,
or the pad's other sides are as near. The pad has an upright side; the surface extends beyond it.

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
# slip, for each unit of Re and of Kn (`squeezefilm-verification edge-flow`). Beside a pad that is
# thin, or ends at the surface's rim, gas spreads to twice the angle: half of the logarithm.
EDGE_RESISTANCE, EDGE_INERTANCE, NEAR_WAVE_RATIO = 0.64, 0.097, 1.12
EDGE_RESISTANCE_ERROR, EDGE_INERTANCE_ERROR = (0.1, 0.15, 3.0), (0.4, 0.0, 3.0)
# Laws of the pressure on the edge: loss coefficient, and parts of the resistance and inertance of
# flow around it. Each effect alone; and both together, with what tells the error of the latter.
SEPARATE_LAWS = (*((coefficient, 0.0, 0.0) for coefficient in EDGE_LOSS_COEFFICIENTS), (0, 1, 1))
JOINT_LAWS = (
    *((coefficient, 1.0, 1.0) for coefficient in EDGE_LOSS_COEFFICIENTS),
    *((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
)
# Relative error of the force that an iteration of the state may leave.
STATE_FORCE_TOLERANCE = 1e-5
# Change of the effect, over it, at which the iteration ends; steps that it may take.
EFFECT_CHANGE_TOLERANCE, MAX_EDGE_ITERATIONS = 3e-3, 100
# Part of that which the next change may take, if expected by the fall of the last two.
CONVERGENCE_SAFETY_FACTOR = 20
# Step of the iteration, over a whole one, below which it has failed.
MIN_EDGE_STEP = 1e-3
# Pressures on the edge over the ambient one in whose effects higher orders do not count. At the
# first no state may be found of a film of large amplitude, at the second rounding counts more.
TRIAL_EDGE_PRESSURE_RATIOS = (1e-3, 1e-4)


def edge_effect_changes(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution],
    *,
    laws: Sequence[tuple[float, float, float]],
    device: Device,
) -> np.ndarray:
    """Return the relative changes of the forces by the pressure on the edge, and their errors.

    Args:
        solutions: of the scenes, with their states on two grids, of STATE_FORCE_TOLERANCE at most.
        laws: as SEPARATE_LAWS.

    Returns:
        Changes and errors by each law, shape (2, laws, scenes); NaN where a solution has no states,
        or the iteration does not settle.
    """
    changes = force_changes_and_errors(
        scenes,
        solutions,
        partial(_edge_effect_changes_on_grid, laws=laws, device=device),
        changes=len(laws),
        tolerance=STATE_FORCE_TOLERANCE,
    )
    changes[1] += EFFECT_CHANGE_TOLERANCE * np.abs(changes[0])
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
    films: Fields, *, laws: Sequence[tuple[float, float, float]], device: Device
) -> np.ndarray:
    """Changes of the mean pressure over it on one grid, (laws, scenes)."""
    count, copies = len(films.scenes), len(laws)
    mean_without_law = np.tile(films.mean(films.gauge_pressure_ratio), copies)
    films = films.at(np.tile(np.arange(count), copies))
    factors = np.repeat(laws, count, axis=0).T
    factors[1] *= EDGE_RESISTANCE
    factors[2] *= edge_inertance(films.scenes)
    change, difference = np.zeros(count * copies), np.full(count * copies, np.nan)
    step, moved = np.ones(count * copies), np.full(count * copies, np.inf)
    known = np.zeros(count * copies, dtype=bool)
    rows = np.arange(count * copies)  # that are still solved for
    for iteration in range(MAX_EDGE_ITERATIONS):
        active = films.at(rows)
        move = edge_pressure_of_flow(active, factors[:, rows]) - active.edge_gauge_pressure
        before, moved[rows] = moved[rows], np.abs(move).max(axis=(1, 2, 3))
        # High harmonics of a large loss overshoot.
        step[rows] /= np.where(moved[rows] > before, 4, 1)
        edge = active.edge_gauge_pressure + step[rows, None, None, None] * move
        tried, mean = solve_with_edge_pressure(active, edge, device=device)
        failed, last, earlier = np.isnan(mean), change[rows], difference[rows]
        change[rows] = np.where(failed, last, mean / mean_without_law[rows] - 1)
        # The first change is the effect, and no step of the iteration.
        difference[rows] = np.abs(change[rows] - last) if iteration else np.nan
        allowed = step[rows] * EFFECT_CHANGE_TOLERANCE * np.abs(change[rows])
        # Or where the next difference, by the fall of the last two, is far below that.
        settled = ~failed & (
            (difference[rows] <= allowed / 2)
            | (difference[rows] ** 2 <= allowed / CONVERGENCE_SAFETY_FACTOR * earlier)
        )
        # Where Newton's method does not follow, a shorter step is tried.
        films.edge_gauge_pressure[rows[~failed]] = edge[~failed]
        films.unknowns[rows[~failed]] = tried.unknowns[~failed]
        step[rows] = np.where(failed, step[rows] / 2, np.minimum(1.5 * step[rows], 1.0))
        known[rows[settled]] = True
        rows = rows[~settled & np.isfinite(change[rows]) & (step[rows] > MIN_EDGE_STEP)]
        if not len(rows):
            break
    return np.where(known, change, np.nan).reshape(copies, count)


def solve_with_edge_pressure(
    films: Fields, edge: np.ndarray, *, device: Device
) -> tuple[Fields, np.ndarray]:
    """Return states with a pressure on the edge, and their means, NaN where there is none."""
    films = replace(films, edge_gauge_pressure=edge)
    return solve_perturbed_states(
        films, edge_pressure_arrays(films), tolerance=STATE_FORCE_TOLERANCE, device=device
    )


def edge_pressure_of_flow(films: Fields, factors: np.ndarray) -> np.ndarray:
    """Return the pressure on the edge, P − 1, by the velocity of states that have some there.

    Args:
        factors: loss coefficient C, resistance and inertance of each scene, (3, scenes).
    """
    loss, resistance, inertance = factors[..., None, None, None]
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
    if np.all(power == 2):  # isothermal, (P² − 1)/2
        potential = rise * (1 + rise / 2)
    else:
        # Of no gas where a step has overshot below vacuum: NaN, and a shorter one is tried.
        with np.errstate(invalid="ignore"):
            potential = ((1 + rise) ** power - 1) / power
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
