"""Motion of the vibration profile past a sliding pad, which the film equation takes as at rest.

The surface that slides at U = 2Λ/σ along the pad's x axis carries its profile along: the pad's
place x₀ on it falls, and the mass of a film at rest on the surface is one more source,

    ∂(Hρ)/∂T → ∂(Hρ)/∂T − U ∂(Hρ)/∂x₀,

lengths by the pad's along x, time by 1/ω. The force at a place then is that of places passed
before, by about the way of the pad in the film's memory σ/(2π²ω). The source follows from states at
neighbouring places, each time with the source of the order before; the orders are powers of U.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.quantities.derivatives import scene_with_quantity_changed
from squeezefilm.quantities.fields import Fields
from squeezefilm.quantities.states import force_changes_and_errors, solve_perturbed_states
from squeezefilm.reynolds.device import Device
from squeezefilm.solution import Solution

# Relative error of the force that an iteration of the state may leave.
STATE_FORCE_TOLERANCE = 1e-6
# Distance of neighbouring places, of the pad's length along x.
NEIGHBOUR_DISTANCE_FRACTION = 0.01
# Largest ratio of the second order to the first up to which the orders are taken to fall.
MAX_SECOND_TO_FIRST_ORDER = 0.5


def moving_profile_changes(
    scenes: Sequence[Scene], solutions: Sequence[Solution], *, device: Device
) -> np.ndarray:
    """Return what the profile's motion changes of the forces, over them, to second order in U.

    Args:
        solutions: of the scenes, with their states on two grids.

    Returns:
        Changes and their errors by grids, iterations and higher orders, shape (2, 1, scenes); NaN
        where a solution has no states or the orders do not fall.
    """
    changes, errors = force_changes_and_errors(
        scenes,
        solutions,
        partial(_moving_profile_changes_on_grid, device=device),
        changes=2,
        tolerance=STATE_FORCE_TOLERANCE,
    )
    # The gas' own memory, Re/10 of its velocity, over the film's.
    lag = np.array([2 * scene.modified_reynolds / scene.sigma for scene in scenes])
    return np.array([changes[:1], [errors[0] + changes[1] + lag * np.abs(changes[0])]])


def _moving_profile_changes_on_grid(own: Fields, *, device: Device) -> np.ndarray:
    """Changes of the mean pressure over it, and what orders above the second may add."""
    count = len(own.scenes)
    moved_scenes = [
        scene_with_quantity_changed(
            scene, "x_m", steps * NEIGHBOUR_DISTANCE_FRACTION * scene.pad.length_x_m
        )
        for steps in range(-2, 3)
        for scene in own.scenes
    ]
    films = Fields.of(moved_scenes, own.grid, np.concatenate([own.unknowns] * 5))
    source: dict[str, np.ndarray] = {}
    means, pressures = [], []
    for order in range(3):
        films, means_here = solve_perturbed_states(
            films, source, tolerance=STATE_FORCE_TOLERANCE, device=device
        )
        middle = slice(count * (2 - order), count * (3 - order))
        means.append(means_here[middle])
        pressures.append(films.unknowns[middle, 0])
        if order == 2:
            break
        mass = (films.area * films.mass)[films.inner]
        films = films.at(slice(count, -count))
        per_distance = films.equation_numbers("bearing", absent=0.0) / NEIGHBOUR_DISTANCE_FRACTION
        source = {"edge_flow": per_distance * (mass[2 * count :] - mass[: -2 * count])}
    first, second = np.diff(means, axis=0) / means[0]
    sizes = [_root_mean_square(each) for each in (pressures[0], *np.diff(pressures, axis=0))]
    moves = sizes[1] > 10 * STATE_FORCE_TOLERANCE * sizes[0]
    ratio = np.divide(sizes[2], sizes[1], out=np.zeros(count), where=moves)
    # Of a geometric series that falls by half or more, the last order bounds all others.
    higher = np.maximum(np.abs(second), ratio * np.abs(first))
    return np.where(ratio <= MAX_SECOND_TO_FIRST_ORDER, [first + second, higher], np.nan)


def _root_mean_square(fields: np.ndarray) -> np.ndarray:
    """Return the root of each scene's mean square, (scenes,)."""
    return np.asarray(np.sqrt((fields**2).mean(axis=(1, 2, 3))))
