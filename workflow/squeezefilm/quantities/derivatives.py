"""Derivatives of the mean force to gap, amplitude, position and the gas' numbers.

A derivative is the difference of the forces of two films whose number is a little larger and
smaller, solved from the scene's own state on the grids of that state: whatever terms the film has.
All is done on the kept states' two grids, whose difference gives the error.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.states import (
    MIN_FORCE_TOLERANCE,
    error_per_grid_change,
    row_groups_on_equal_grids,
    with_states,
)
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.packing import equation_numbers_table
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.refinement import are_many
from squeezefilm.reynolds.periodic.resolution import profile_error_ratio
from squeezefilm.reynolds.plan import solve_plan_of
from squeezefilm.reynolds.terms import terms_of, unsupported_on_grid_reason
from squeezefilm.solution import DERIVATIVE_COLUMNS, Derivatives, Solution, Solutions

# A derivative's change from grid to grid is no less than this fraction of the largest of a scene's:
# without it 15 of 5156 of 200 random films were off by up to 8 times their error.
MIN_GRID_CHANGE_FRACTION = 0.3
# Half of the difference, over the number's unit, and what third order misses of the quotient.
DIFFERENCE_STEP, DIFFERENCE_STEP_ERROR = 3e-5, 1e-6
# Fraction of the tolerance, times the step, that the iterations of the two films may leave.
ITERATION_ERROR_FRACTION_OF_STEP = 0.1
NEIGHBOUR_FAILED_STATUS = "not converged: a film beside this one, for the derivatives"


def with_derivatives(
    scenes: Scenes | Sequence[Scene],
    solutions: Sequence[Solution],
    *,
    tolerance: float,
    device: Device | None = None,
) -> Solutions:
    """The scenes' forces, as ``solve`` gave them, with derivatives, by the states if it kept them.

    They are those of the periodic state, by whichever method its force was found.
    """
    tolerance = max(tolerance, MIN_FORCE_TOLERANCE)
    solutions = Solutions.of(solutions)
    known = np.flatnonzero(np.isfinite(solutions.force_n))
    films = Scenes.of(scenes)[known]
    results = [Derivatives(status="no force")] * len(solutions)
    solved = with_states(films, solutions[known], tolerance=tolerance, device=device)
    for row, status in zip(known.tolist(), solved.status, strict=True):
        results[row] = Derivatives(status=status)
    device = device or choose_device()
    for rows in row_groups_on_equal_grids(films, solved):
        of_group = _derivatives_of_group(
            films[rows], solved[rows], tolerance=tolerance, device=device
        )
        for row, derivatives_of_scene in zip(known[rows].tolist(), of_group, strict=True):
            results[row] = derivatives_of_scene
    return solutions.with_replaced_column("derivatives", results)


def _derivatives_of_group(
    scenes: Scenes, solutions: Solutions, *, tolerance: float, device: Device
) -> list[Derivatives]:
    """Derivatives of scenes of like terms, by two grids."""
    before, _ = _scaled_derivatives_on_grid(
        scenes, solutions, 0, tolerance=tolerance, device=device
    )
    growth, missed = _scaled_derivatives_on_grid(
        scenes, solutions, 1, tolerance=tolerance, device=device
    )
    change = np.abs(growth - before)
    # A derivative may agree by chance, or be small because its parts cancel; not all do.
    with np.errstate(invalid="ignore"):
        largest = np.fmax.reduce(change, axis=0)
        change = np.where(growth != 0, np.fmax(change, MIN_GRID_CHANGE_FRACTION * largest), 0.0)
    factor, _ = error_per_grid_change(scenes, solutions, tolerance=tolerance)
    error = factor * change + missed
    coarse, fine = (state.grid for state in solutions.states[0])
    falls = profile_error_ratio(
        solve_plan_of(scenes), coarse.nodes_across, fine.nodes_across, tolerance=tolerance
    )
    # What grids miss of a force by a profile that they do not resolve changes with the place as
    # fast as their shortest wave, π times the nodes; and two grids may agree on it by chance.
    indices = map([*DERIVATIVE_COLUMNS].index, ("x_m", "y_m"))
    for k, nodes in zip(indices, fine.nodes_across, strict=True):
        nodes = fine.nodes_across[0] if fine.pad_coordinates else nodes
        unresolved_n = np.where(falls > 0, np.pi * nodes * solutions.force_error_n, 0.0)
        error[k] = np.where(growth[k] != 0, np.fmax(error[k], unresolved_n), error[k])
    return [
        _derivatives_of_scene(scene, growth[:, k], error[:, k]) for k, scene in enumerate(scenes)
    ]


def _scaled_derivatives_on_grid(
    scenes: Scenes, solutions: Solutions, grid_index: int, *, tolerance: float, device: Device
) -> tuple[np.ndarray, np.ndarray]:
    """The mean forces' growth with each number times its unit (``_scale_of_quantity``), by one
    grid.

    Returns:
        The growths in newtons and what iterations and differences may leave of them, each of shape
        (numbers, scenes); NaN for a number that has no films beside.
    """
    own = [states[grid_index] for states in solutions.states]
    grid, state = own[0].grid, np.stack([each.unknowns for each in own])
    growth, missed = np.full((2, len(DERIVATIVE_COLUMNS), len(scenes)), np.nan)
    folded = {"x_m": grid.fold_x, "y_m": grid.fold_y}
    for k, quantity in enumerate(DERIVATIVE_COLUMNS):
        beside = [
            scene_with_quantity_changed(
                scene, quantity, sign * DIFFERENCE_STEP * _scale_of_quantity(scene, quantity)
            )
            for sign in (1, -1)
            for scene in scenes
        ]
        ahead, behind = beside[: len(scenes)], beside[len(scenes) :]
        scale = np.array([scene.force_scale_n for scene in beside])
        if folded.get(quantity):  # the force is even in the place
            growth[k], missed[k] = 0.0, 0.0
            continue
        if all(_equation_key(a) == _equation_key(b) for a, b in zip(ahead, behind, strict=True)):
            wider, narrower = scale.reshape(2, -1)
            growth[k] = (
                solutions.force_n * (wider - narrower) / (wider + narrower) / DIFFERENCE_STEP
            )
            missed[k] = 0.0
            continue
        if unsupported_on_grid_reason(beside[0], terms_of(beside[0])):
            continue
        states = solve_batch(
            beside,
            grid,
            tolerance=ITERATION_ERROR_FRACTION_OF_STEP * DIFFERENCE_STEP * tolerance,
            device=device,
            guess=np.concatenate([state, state]),
            many=are_many(beside),
        )
        known = states.status_indices == 0
        forces_n = np.where(known, states.mean_pressure_ratio * scale, np.nan).reshape(2, -1)
        left_n = (states.result_rows["residual"] * scale).reshape(2, -1).sum(
            axis=0
        ) / scenes.narrowest_gap_ratio
        growth[k] = (forces_n[0] - forces_n[1]) / (2 * DIFFERENCE_STEP)
        missed[k] = left_n / (2 * DIFFERENCE_STEP) + DIFFERENCE_STEP_ERROR * np.abs(growth[k])
    return growth, missed


def _equation_key(scene: Scene) -> object:
    """All that a scene's dimensionless equation depends on."""
    scenes = Scenes.of([scene])
    return equation_numbers_table(scenes, terms_of(scene)).tobytes(), scenes.pad_positions[0]


def _derivatives_of_scene(scene: Scene, growth: np.ndarray, error: np.ndarray) -> Derivatives:
    """A scene's derivatives, those to its place turned into the actuator's axes."""
    # A gas with thermal effects has no other polytropic exponent: that derivative alone is missing.
    needed = [name != "polytropic_exponent" for name in DERIVATIVE_COLUMNS]
    if not np.isfinite(error[needed]).all():
        return Derivatives(status=NEIGHBOUR_FAILED_STATUS)
    units, pad = [_scale_of_quantity(scene, quantity) for quantity in DERIVATIVE_COLUMNS], scene.pad
    values = dict(zip(DERIVATIVE_COLUMNS, (growth / units).tolist(), strict=True))
    errors = dict(zip(DERIVATIVE_COLUMNS, (error / units).tolist(), strict=True))
    values["x_m"], values["y_m"] = pad.to_actuator_axes(values["x_m"], values["y_m"])
    from_x = pad.to_actuator_axes(errors["x_m"], 0.0)
    from_y = pad.to_actuator_axes(0.0, errors["y_m"])
    errors["x_m"], errors["y_m"] = (abs(a) + abs(b) for a, b in zip(from_x, from_y, strict=True))
    return Derivatives(value=values, error=errors, status="ok")


def scene_with_quantity_changed(scene: Scene, quantity: str, by: float) -> Scene:
    """The scene with another number; ``x_m`` and ``y_m`` are along the pad's own axes."""
    if quantity in ("x_m", "y_m"):
        x_m, y_m = scene.pad.to_actuator_axes(*((by, 0.0) if quantity == "x_m" else (0.0, by)))
        return replace(scene, x_m=scene.x_m + x_m, y_m=scene.y_m + y_m)
    if quantity in ("h0_m", "hv_m"):
        return replace(scene, **{quantity: getattr(scene, quantity) + by})
    return scene.with_gas(**{quantity: getattr(scene.gas, quantity) + by})


def _scale_of_quantity(scene: Scene, quantity: str) -> float:
    """Return the scale of a number: itself, or the gap or the length that it goes with."""
    if quantity in ("h0_m", "hv_m"):
        return scene.h0_m
    if quantity in ("x_m", "y_m"):
        return scene.pad.length_x_m
    return float(getattr(scene.gas, quantity))
