"""Quantities beside the mean force, from the periodic state, each with an error: docs/outputs.md.

All that are means over film and period ask of the pressure no more than p₀ + p₁ sin T + p₂ cos T at
every point, for the gap that weighs them has no other harmonics: each is ⟨w (P − 1)⟩ of a weight
w₀ + w₁ sin T + w₂ cos T, shape (3, Q). Forces are those of the gas on the pad; x and y are the
actuator's axes, z points from the surface to the pad.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from math import isnan, nan
from typing import Any

import numpy as np

from squeezefilm.errors import unexpected_error_status
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.derivatives import with_derivatives
from squeezefilm.quantities.fields import Fields
from squeezefilm.quantities.sheared_gas import (
    first_order_remainder_of_scene,
    scaled_sheared_gas_thrust,
)
from squeezefilm.quantities.states import MIN_FORCE_TOLERANCE, error_per_grid_change, with_states
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.error_estimate import ALLOWED_ROUND_OFF_FACTOR, RELATIVE_ROUND_OFF
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import PeriodicStates
from squeezefilm.reynolds.plan import solve_plan_of
from squeezefilm.reynolds.solver import known_solutions, solve
from squeezefilm.reynolds.spectral import AngleAxis, flux_points
from squeezefilm.reynolds.terms.thermal import Thermal
from squeezefilm.solution import (
    OUTPUT_COLUMNS,
    Outputs,
    Solution,
    Solutions,
    validated_output_names,
)

# A scene is solved again to this share of the tolerance, and so on, until its outputs hold it.
TIGHTER_TOLERANCE_FACTOR, MAX_TIGHTER_SOLVES = 1 / 30, 3
# No output changes less than this share of the largest change among those alike, each over its
# size: it may agree by chance, or be small because its parts cancel.
MIN_GRID_CHANGE_FRACTION = 0.3
# An extreme is one value of a polynomial, which nothing averages: the worst of 600 random films at
# 1e-2 needed 2.8 times what its change and the iteration left.
EXTREMES_ERROR_FACTOR = 4.0
# Distance of the points whose gaps' difference is a slope, of the pad's length: waves as long as
# a tenth of it are missed by 4e-9, and as little is rounded where the surface hardly moves.
GAP_SLOPE_STEP = 3e-4
# Of a field, what rounding leaves of an odd one that is made even.
ODD_FIELD_ROUND_OFF = 1e-9
# Motion with cos ωt over ε that counts as none.
NEGLIGIBLE_QUADRATURE_MOTION = 1e-14
# Cosine moments along each side, and first harmonics of them, that stand by the outputs: the change
# of an output from grid to grid may be small by chance, that of all these hardly.
GUARD_MOMENT_COUNT, GUARD_MOMENT_NAME, FORCE_NAME = 3, "guard", "force"
STATE_OUTPUT_NAMES = frozenset(OUTPUT_COLUMNS) - {"static_stiffness"}
QUARTER_PHASES = np.pi / 2 * np.arange(4)
# Numbers, each with its error, and the reason for each missing output.
ValuesAndReasons = tuple[dict[str, tuple[float, float]], dict[str, str]]


def with_outputs(
    scenes: Scenes | Sequence[Scene],
    solutions: Sequence[Solution],
    *,
    outputs: Sequence[str],
    tolerance: float,
    device: Device | None = None,
) -> Solutions:
    """The scenes' forces, as ``solve`` gave them, with outputs, by the states if it kept them.

    They are those of the periodic state, by whichever method its force was found. Where their
    errors are above the tolerance, states to a tighter one are solved for.
    """
    asked = validated_output_names(outputs)
    solutions = Solutions.of(solutions)
    if not asked:
        return solutions
    known = np.flatnonzero(np.isfinite(solutions.force_n))
    films, forces = Scenes.of(scenes)[known], solutions[known]
    parts: list[ValuesAndReasons] = [({}, {})] * len(known)
    if STATE_OUTPUT_NAMES & set(asked):
        within = max(tolerance, MIN_FORCE_TOLERANCE)
        parts = _outputs_from_states(films, forces, tolerance=within, device=device)
    if "static_stiffness" in asked:
        more = static_stiffness_outputs(films, forces, tolerance=tolerance, device=device)
        parts = [(one | other, a | b) for (one, a), (other, b) in zip(parts, more, strict=True)]
    outputs_of_row = [Outputs.of(asked, {}, dict.fromkeys(OUTPUT_COLUMNS, "no force"))] * len(
        solutions
    )
    for row, (values, missing) in zip(known.tolist(), parts, strict=True):
        outputs_of_row[row] = Outputs.of(asked, values, missing)
    return solutions.with_replaced_column("outputs", outputs_of_row)


def missing_output_reasons(scene: Scene, *, tolerance: float) -> dict[str, str]:
    """Return the reasons for missing outputs that are known before solving.

    By their names in OUTPUT_COLUMNS. Inertia must be decided.
    """
    within = max(tolerance, MIN_FORCE_TOLERANCE)
    (solution,), _ = known_solutions(solve_plan_of(scene), tolerance=within, method="periodic")
    reason = solution.status
    return dict.fromkeys(OUTPUT_COLUMNS, reason) if reason else _reasons_without_formula(scene)


def _reasons_without_formula(scene: Scene) -> dict[str, str]:
    """Return the reason for each missing or partial output, by its name in OUTPUT_COLUMNS."""
    reasons = {}
    if scene.epsilon == 0:
        reasons["harmonics"] = "stiffness and damping are not known of a surface at rest"
    elif (
        np.abs(gap_harmonics(scene, *scene.inside())[2]).max()
        > NEGLIGIBLE_QUADRATURE_MOTION * scene.epsilon
    ):
        reasons["harmonics"] = (
            "stiffness and damping are of a surface with one quadrature component"
        )
    if scene.bearing_number != 0 and scene.gas.rarefaction == "fukui-kaneko":
        reasons["thrust"] = "the shear of a sliding wall is not derived with fukui-kaneko"
    elif _wall_drags_gas(scene) and isnan(first_order_remainder_of_scene(scene, vibrating=1.0)):
        reasons["thrust"] = (
            "inertia and heat of the gas that a sliding wall drags are known to first order; here "
            "higher orders are as large; gas.inertia: none with gas.thermal: none has the thrust "
            "without them"
        )
    return reasons


def _wall_drags_gas(scene: Scene) -> bool:
    """Return whether a sliding wall drags gas that has inertia or heat."""
    included = "included" in (scene.gas.inertia, scene.gas.thermal)
    return included and bool(scene.bearing_number != 0)


def _outputs_from_states(
    scenes: Scenes, solutions: Solutions, *, tolerance: float, device: Device | None
) -> list[ValuesAndReasons]:
    """All outputs that follow from a periodic state, or why there are none."""
    outputs_of_row: dict[int, ValuesAndReasons] = {}
    waiting, solved = np.arange(len(scenes)), solutions
    for repeated in range(1 + MAX_TIGHTER_SOLVES):
        within = tolerance * TIGHTER_TOLERANCE_FACTOR**repeated
        solved = with_states(scenes[waiting], solved, tolerance=within, device=device)
        further = []
        for row, k in enumerate(waiting.tolist()):
            if not solved.states[row]:
                outputs_of_row.setdefault(k, _unsupported_outputs(solved.status[row]))
                continue
            try:
                alone = scenes[k : k + 1], solved[row : row + 1]
                outputs_of_row[k], holds = _outputs_on_two_grids(
                    *alone, tolerance=tolerance, device=device
                )
            except Exception as error:  # that of one film is no one else's
                outputs_of_row[k] = _unsupported_outputs(unexpected_error_status(error))
                holds = True
            if not holds:
                further.append(k)
        if not further:
            break
        waiting, solved = np.array(further), Solutions.unsolved_of_method("periodic", len(further))
    return [outputs_of_row[k] for k in range(len(scenes))]


def _unsupported_outputs(reason: str) -> ValuesAndReasons:
    return {}, dict.fromkeys(STATE_OUTPUT_NAMES, reason)


def _outputs_on_two_grids(
    scenes: Scenes, solutions: Solutions, *, tolerance: float, device: Device | None
) -> tuple[ValuesAndReasons, bool]:
    """Outputs of one film from its states on two grids, and whether they hold the tolerance."""
    (scene,), (states,) = scenes, solutions.states
    before, film = (SampledState(scene, state) for state in states)
    factor, left = (
        each.item() for each in error_per_grid_change(scenes, solutions, tolerance=tolerance)
    )
    largest = max(film.largest, -film.least)
    left += RELATIVE_ROUND_OFF * largest
    # What rounding and the iteration leave is no reason for a finer grid.
    allowed = ALLOWED_ROUND_OFF_FACTOR * RELATIVE_ROUND_OFF * largest / (1 - scene.closure()) + left
    coarse, fine = output_weights(before), output_weights(film)
    size = {name: film.size(weight) for name, weight in fine.items()}
    # The value of each number and its error.
    values = {name: (film.weighted_excess_mean(weight), 0.0) for name, weight in fine.items()}
    holds, least = True, 0.0
    for first_harmonics in (False, True):
        # Those that ask for harmonics are of first order in the amplitude, the others of second.
        comparable = [
            n for n, w in fine.items() if bool(np.any(w[1:])) == first_harmonics and size[n]
        ]
        change = {
            n: abs(values[n][0] - before.weighted_excess_mean(coarse[n])) / size[n]
            for n in comparable
        }
        scale = max((abs(values[n][0]) / size[n] for n in comparable), default=0.0)
        most = max(change.values(), default=0.0)
        least = max(least, MIN_GRID_CHANGE_FRACTION * most)
        holds &= factor * most <= tolerance * scale + allowed
        for n in comparable:
            error = factor * max(change[n], MIN_GRID_CHANGE_FRACTION * most) + left
            values[n] = values[n][0], size[n] * error
    ambient, missing = scene.gas.ambient_pressure_pa, _reasons_without_formula(scene)
    ends = [(film.largest, before.largest), (film.least, before.least)]
    change_of_ends = max([least * largest, *(abs(a - b) for a, b in ends)])
    for name, (peak, _) in zip(OUTPUT_COLUMNS["extremes"], ends, strict=True):
        values[name] = (
            ambient * peak,
            ambient * EXTREMES_ERROR_FACTOR * (factor * change_of_ends + left),
        )
    (force, doubt), speed = values[FORCE_NAME], scene.actuator.angular_frequency_rad_per_s
    for name, moment, sign in (("centre_x", "moment_y", -1), ("centre_y", "moment_x", 1)):
        if abs(force) > 2 * doubt:  # without a force it acts nowhere
            arm, error = sign * values[moment][0] / force, values[moment][1]
            values[name] = arm, (error + abs(arm) * doubt) / (abs(force) - doubt)
    if "harmonics" not in missing:
        for name, part, per in (
            ("film_stiffness", "force_in_phase", scene.hv_m),
            ("film_damping", "force_quadrature", scene.hv_m * speed),
        ):
            values[name] = -values[part][0] / per, values[part][1] / per
    drag = _couette_drag_n(film)
    # Slip goes by the density.
    change_of_drag = max(
        abs(drag - _couette_drag_n(before)), least * 2 * scene.slip_knudsen * abs(drag)
    )
    values["sliding_friction"] = drag, factor * change_of_drag + RELATIVE_ROUND_OFF * abs(drag)
    parts = [values["sliding_friction"], (0.0, 0.0)]
    if scene.gas.inertia == "included":  # half of what leaves is taken from the pad
        # Share of it that warm gas would change: twice its warming where it streams.
        heats = scene.gas.thermal == "included"
        warm = (
            2 * float(Thermal().equation_numbers(scene)["heating"]) * scene.epsilon**2 / 20
            if heats
            else 0
        )
        for k, (one, other) in enumerate(zip(before.momentum_n, film.momentum_n, strict=True)):
            off = factor * abs(other - one) + warm * abs(other)
            parts[k] = parts[k][0] - other / 2, parts[k][1] + off / 2
    if _wall_drags_gas(scene) and "thrust" not in missing:
        with_gas = scaled_sheared_gas_thrust(scene, solutions[0], device=device or choose_device())
        by_gas, off_gas = with_gas * scene.force_scale_n * scene.h0_m / scene.pad.length_x_m
        missed = first_order_remainder_of_scene(scene, vibrating=1.0) * np.abs(film.momentum_n) / 2
        for k, (value, off) in enumerate(parts):
            parts[k] = float(value + by_gas[k]), float(off + off_gas[k] + missed[k])
        if np.isnan(by_gas).any():
            missing["thrust"] = "not converged: the film with the gas that the sliding wall drags"
    x, y = scene.pad.to_actuator_axes(1.0, 0.0)
    for name, turned in (("thrust_x", (x, -y)), ("thrust_y", (y, x))):
        for (drawn, off), component in zip(parts, turned, strict=True):
            values[name] = (
                values[name][0] + component * drawn,
                values[name][1] + abs(component) * off,
            )
    if "thrust" in missing:
        del values["thrust_x"], values["thrust_y"]
        if scene.gas.rarefaction == "fukui-kaneko":
            del values["sliding_friction"]
    return (values, missing), holds


def _couette_drag_n(film: SampledState) -> float:
    """Couette drag μ U ⟨1/(h + 2 σ λ)⟩ times the area in newtons, with slip at both walls."""
    scene, fields = film.scene, film.fields
    gap = fields.gap + 2 * scene.slip_knudsen / fields.density
    shear = scene.gas.viscosity_pa_s * scene.pad.speed_x_m_per_s / scene.h0_m
    return float(shear * scene.pad.area_m2 * fields.mean(1 / gap)[0])


def output_weights(film: SampledState) -> dict[str, np.ndarray]:
    """Return the weights by the names in OUTPUT_COLUMNS (solution.py), of ``force`` and of
    guards."""
    scene, pad = film.scene, film.scene.pad
    force = scene.force_scale_n
    one, nothing = np.ones_like(film.x), np.zeros_like(film.x)
    x, y = pad.to_actuator_axes((film.x - 0.5) * pad.length_x_m, (film.y - 0.5) * pad.length_y_m)
    _, sine, cosine = gap_harmonics(scene, film.x, film.y)
    speed = scene.h0_m * scene.actuator.angular_frequency_rad_per_s
    # Shear at the pad's wall by the flow that pressure drives, −(h/2) ∇p, in the mean over the
    # pad ½ ⟨p ∇h⟩ as p vanishes on the edge; and pressure on the wall's own slope, −⟨p ∇g⟩, g being
    # the gap at rest.
    lengths = pad.length_x_m, pad.length_y_m
    thrust_x, thrust_y = pad.to_actuator_axes(
        *(
            slope / length * np.array([-0.5, 0.5, 0.5])[:, None]
            for slope, length in zip(film.slopes, lengths, strict=True)
        )
    )
    weights = {
        FORCE_NAME: force * np.stack([one, nothing, nothing]),
        "moment_x": force * np.stack([y, nothing, nothing]),
        "moment_y": force * np.stack([-x, nothing, nothing]),
        # F₁ of F₀ + F₁ sin T + F₂ cos T is twice the mean with sin T.
        "force_in_phase": 2 * force * np.stack([nothing, one, nothing]),
        "force_quadrature": 2 * force * np.stack([nothing, nothing, one]),
        # −p ∂h/∂t, the work that the surface does against the pressure.
        "power": force * speed * np.stack([nothing, cosine, -sine]),
        "thrust_x": force * scene.h0_m * thrust_x,
        "thrust_y": force * scene.h0_m * thrust_y,
    }
    for k, n, part in np.ndindex(GUARD_MOMENT_COUNT, GUARD_MOMENT_COUNT, 3):
        wave = np.cos(2 * np.pi * k * film.x) * np.cos(2 * np.pi * n * film.y)
        weights[f"{GUARD_MOMENT_NAME} {k} {n} {part}"] = np.eye(3)[part][:, None] * wave
    return {name: film.symmetric_part(weight) for name, weight in weights.items()}


class SampledState:
    """One film's state with what outputs ask of it.

    Attributes:
        fields: the state, at the nodes that its symmetry leaves, those of the edge among them.
        x, y: points across the pad in [0, 1], mirror images among them, shape (Q,). In an outline's
            or a disc's coordinates each place lies at two of them.
        largest, least: of P − 1 over pad and period.
        momentum_n: what leaves over the edge along the pad's x and y, of a gas with inertia.
    """

    def __init__(self, scene: Scene, state: PeriodicStates) -> None:
        self.scene, grid = scene, state.grid
        self.fields = Fields.of([scene], grid, state.unknowns[None])
        self.x, self.y = grid.node_positions
        self.largest = _interpolated_maximum(state.unknowns[0], grid, sign=1)
        self.least = -_interpolated_maximum(state.unknowns[0], grid, sign=-1)
        inert = scene.gas.inertia == "included"
        self.momentum_n = momentum_outflow_n(self.fields).tolist() if inert else [0.0, 0.0]

    @cached_property
    def pressure(self) -> np.ndarray:
        """Pressure's mean and its factors of sin T and cos T at the nodes, shape (3, x, y)."""
        phases = self.fields.grid.t.nodes
        parts = np.stack([np.ones_like(phases), 2 * np.sin(phases), 2 * np.cos(phases)])
        mean_with = self.fields.gauge_pressure_ratio[0] @ parts.T / len(phases)
        return np.moveaxis(mean_with, -1, 0)

    @cached_property
    def slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """The gap's derivatives along the pad's x and y, over its lengths: each (3, Q)."""
        return self._gap_slope(GAP_SLOPE_STEP, 0.0), self._gap_slope(0.0, GAP_SLOPE_STEP)

    def _gap_slope(self, in_x: float, in_y: float) -> np.ndarray:
        """Return a difference of fourth order, which takes the profile beyond the edge too."""
        far, near, after, beyond = (
            gap_harmonics(self.scene, self.x + k * in_x, self.y + k * in_y) for k in (-2, -1, 1, 2)
        )
        return np.asarray((8 * (after - near) - (beyond - far)) / (12 * (in_x + in_y)))

    def symmetric_part(self, field: np.ndarray) -> np.ndarray:
        """Return the part of a field (3, Q) that counts in a mean with the pressure, (3, x, y)."""
        grid, (_, count_x, count_y) = self.fields.grid, self.pressure.shape
        seen = field.reshape(3, len(grid.x.all_nodes), len(grid.y.all_nodes))
        if isinstance(grid.y, AngleAxis):
            for order in grid.y.mirror_image_indices:
                seen = (seen + seen[..., order]) / 2
        else:
            seen = (seen + seen[:, ::-1]) / 2 if grid.x.folded else seen
            seen = (seen + seen[..., ::-1]) / 2 if grid.y.folded else seen
        odd = np.abs(seen).max() < ODD_FIELD_ROUND_OFF * np.abs(field).max()
        return seen[:, :count_x, :count_y] * (not odd)

    def weighted_excess_mean(self, weight: np.ndarray) -> float:
        """⟨w (P − 1)⟩ over pad and period, for w₀ + w₁ sin T + w₂ cos T, shape (3, x, y)."""
        return self._pad_mean(_period_mean(weight, self.pressure))

    def size(self, weight: np.ndarray) -> float:
        """Root mean square of a weight over pad and period."""
        return float(np.sqrt(self._pad_mean(_period_mean(weight, weight))))

    def _pad_mean(self, over_period: np.ndarray) -> float:
        return float(self.fields.mean(over_period[None, ..., None])[0])


def _period_mean(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Mean over the period of two fields of three parts, shape (Q,)."""
    return np.asarray(one[0] * other[0] + (one[1] * other[1] + one[2] * other[2]) / 2)


def gap_harmonics(scene: Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The gap over h0 at rest, its motion with sin T and with cos T, shape (3, ...)."""
    at_0, at_90, at_180, at_270 = np.moveaxis(scene.gap(x, y, QUARTER_PHASES), -1, 0)
    return np.stack([(at_90 + at_270) / 2, (at_90 - at_270) / 2, (at_0 - at_180) / 2])


def _interpolated_maximum(field: np.ndarray, grid: Grid, *, sign: int) -> float:
    """Return the maximum of the interpolant of sign · field near its largest node value.

    Args:
        field: at the unknowns, shape (nx, ny, nt); on the edge it is zero.
    """
    from scipy.optimize import minimize

    size = np.abs(field).max() or 1.0

    def negative_interpolant(point: np.ndarray) -> float:
        u, v, phase = point[:, None]
        in_u = np.einsum("pa,abi->pbi", grid.x.matrix_at(u), field)
        minimum = grid.y.matrix_at(v) @ in_u @ grid.t.matrix_at(phase).T
        return -sign * minimum.item() / size

    best = np.unravel_index(int(np.argmax(sign * field)), field.shape)
    nodes = grid.x.nodes, grid.y.nodes, grid.t.nodes
    start = np.array([float(axis_nodes[k]) for axis_nodes, k in zip(nodes, best, strict=True)])
    # On the edge of the pad the pressure is ambient: no extreme but that of a film at rest.
    around = isinstance(grid.y, AngleAxis)
    free = [(None, None) if turns else (0.0, 1.0) for turns in (False, around, True)]
    minimum = minimize(negative_interpolant, start, bounds=free, options={"ftol": 1e-13})
    return float(max(0.0, sign * field[best], -size * minimum.fun))


def momentum_outflow_n(film: Fields) -> np.ndarray:
    """Momentum ⟨∮ρ h β ū ū·n⟩ that a gas with inertia carries over the edge of a film, in newtons.

    The momentum equation integrated over gap, pad and period says that both walls together give the
    gas ⟨∫h∇p⟩ and what leaves over the edge, β = 6/5 for a parabola across the gap; and each gives
    half, for the flow is even about the middle of the gap. On a strip with the velocity resolved
    across the gap that was true of the shear at the wall to 2e-6, 1e-5 and 3e-4 of it at Re 0.45,
    1.8 and 7.2, where what leaves is 1.7, 7 and 30 % of the shear.

    Returns:
        Those along the pad's x and y, shape (2,).
    """
    (scene,), grid = film.scenes, film.grid
    momentum_n, uneven = np.zeros(2), ~np.array([grid.fold_x, grid.fold_y])
    speed = scene.actuator.angular_frequency_rad_per_s * scene.pad.length_x_m
    per_length = scene.gas.density_kg_per_m3 * speed**2 * scene.h0_m
    for k, axis in enumerate(film.axes_with_ends if uneven.any() else ()):
        flux = _momentum_flux_at_ends(film, k)
        if outline := grid.outline:  # both ends of μ are all of the edge; ū is that times |z′|
            along, around = flux[:, 0]
            ways = (along + 1j * around) / film.conformal_map_slope[0, :, 0].conj()
            ways /= outline.mean_edge_jacobian**0.5
            around_n = 2 * np.pi * per_length * scene.pad.length_x_m * outline.mean_edge_jacobian
            momentum_n = np.array([ways.real.mean(), ways.imag.mean()]) * around_n
        else:
            side_m = (scene.pad.length_y_m, scene.pad.length_x_m)[k]
            over_side = (flux @ (grid.y, grid.x)[k].quadrature_weights).sum(axis=1) * (
                1 + axis.folded
            )
            # Along the axis and across it, in the order of x and y.
            momentum_n += np.roll(over_side, k) * per_length * side_m
    # Of an even film as much leaves on both sides, to both sides.
    return momentum_n * uneven


def _momentum_flux_at_ends(film: Fields, k: int) -> np.ndarray:
    """Return ⟨ρ h β ū·n ū⟩ along x or y and across it, at its ends: (2, ends, nodes inside)."""
    axis, other = film.axes_with_ends[k], (film.grid.y, film.grid.x)[k]
    ends = [0] if axis.folded else [0, -1]
    at = film.inner_slices_across(k)
    gap, velocity, outward = (
        np.moveaxis(each[at], 1 + k, 1)[0, ends]
        for each in (film.gap, film.velocity_on_edge[k], -film.inward_normal_signs[k])
    )
    # No pressure drives gas along the edge: its velocity there is the deficit's alone. Gas that
    # comes in has none.
    tangential = np.moveaxis(film.unknowns[0, 2 - k], k, 0)
    near = np.stack([tangential[:4], tangential[:-5:-1]])[: len(ends)]
    at_edge = -np.einsum("j,ejqt->eqt", axis.end_extrapolation_weights, near)
    out = outward * velocity / film.equation_numbers("reversing", absent=nan)[0]
    carried = (
        flux_points(other).matrix_to_inner_nodes @ at_edge * (0.5 + 0.5 * out / np.sqrt(1 + out**2))
    )
    # Mean square of a velocity across the gap over the square of its mean: with slip it is
    # ζ(1 − ζ) + Kn/H, ζ across the gap. There the gas has ambient density.
    slip = film.scenes[0].slip_knudsen / gap
    spread = (1 / 30 + slip / 3 + slip**2) / (1 / 6 + slip) ** 2
    both = np.stack([velocity, carried])
    return np.asarray((spread * gap * outward * velocity * both).mean(axis=-1))


# Half the distance of numbers in a difference quotient, relative; taken once more twice as wide,
# whose difference bounds what the quotient misses.
DIFFERENCE_QUOTIENT_STEP, DIFFERENCE_QUOTIENT_MULTIPLES = 0.01, (-2, -1, 1, 2)


def forces_and_negative_slopes(
    scenes: Sequence[Scene], name: str, **how: Any
) -> tuple[np.ndarray, list[str]]:
    """Return forces F, their errors, −∂F/∂number by difference quotients, and its error.

    Args:
        name: of the number, ``h0_m`` or ``hv_m``.
        how: as ``solve`` takes it.

    Returns:
        The four as rows, (4, n), NaN where a force is missing, and why it is, one text a scene.
    """
    factors = 1 + DIFFERENCE_QUOTIENT_STEP * np.array([0, *DIFFERENCE_QUOTIENT_MULTIPLES])
    count = len(factors)
    unit = np.array([getattr(scene, name) for scene in scenes])
    moved: list[dict[str, Any]] = [
        {name: float(value)} for value in np.outer(unit, factors).ravel()
    ]
    solutions = solve(
        [replace(scenes[k // count], **change) for k, change in enumerate(moved)], **how
    )
    force, a, b, c, d = solutions.force_n.reshape(len(scenes), count).T
    errors = solutions.force_error_n.reshape(len(scenes), count).T
    narrow = (b - c) / (2 * DIFFERENCE_QUOTIENT_STEP * unit)
    wide = (a - d) / (4 * DIFFERENCE_QUOTIENT_STEP * unit)
    # The wide quotient misses four times what the narrow one does.
    noise = (errors[2] + errors[3]) / (2 * DIFFERENCE_QUOTIENT_STEP * unit)
    fall, error = narrow + (narrow - wide) / 3, np.abs(narrow - wide) / 3 + 4 / 3 * noise
    bad = ["" if status == "ok" else status for status in solutions.status]
    reasons = [max(bad[k : k + count]) for k in range(0, len(bad), count)]
    return np.stack([force, errors[0], fall, error]), reasons


def static_stiffness_outputs(
    scenes: Scenes, solutions: Solutions, *, tolerance: float, device: Device | None
) -> list[ValuesAndReasons]:
    """−∂F/∂h0 with the amplitude kept, by the force's derivative, or by a quotient of four forces.

    The scenes' terms must be decided (model_error.py).
    """
    name, stiffnesses = "static_stiffness", list[ValuesAndReasons]()
    solved = with_derivatives(scenes, solutions, tolerance=tolerance, device=device)
    for scene, known in zip(scenes, solved.derivatives, strict=True):
        bad = ""
        if known.status == "ok":
            value, error = -known.value["h0_m"], known.error["h0_m"]
        else:
            rows, (bad,) = forces_and_negative_slopes(
                [scene], "h0_m", tolerance=tolerance, device=device
            )
            value, error = rows[2:, 0].tolist()
        reason = f"no force at a gap within {2 * DIFFERENCE_QUOTIENT_STEP:.0%}: {bad}"
        stiffnesses.append(({}, {name: reason}) if bad else ({name: (value, error)}, {}))
    return stiffnesses
