"""Gain and phase of the mean force by marching a film with a modulated amplitude.

The mean over a period of a force that swings with a changing amplitude depends on the instant at
which the period is cut. Two films are marched, half a period apart (ε and −ε): in their mean that
cancels. Both are marched from their settled states, twice: on another grid, with other steps, with
another time to forget how the modulation began; the difference is the error.
"""

from __future__ import annotations

from math import ceil, pi
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import InputError
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.march.schemes import steps_for_accuracy
from squeezefilm.reynolds.march.settling import settle
from squeezefilm.reynolds.march.transient import STATUS, Modulation, march
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.first_grids import grid_for
from squeezefilm.reynolds.periodic.resolution import finer_grid
from squeezefilm.reynolds.problems import problems_of

SCHEME = "esdirk4"
DEPTH = 0.02
TOLERANCE = 1e-3
# Times of the slowest mode's decay that a march is given to forget how it began.
DECAYS = 8.0
HARMONICS = 2
MOST_PERIODS = 100_000


def gains(
    scene: Scene, modulations: np.ndarray, *, device: Device, depth: float = DEPTH
) -> tuple[np.ndarray, np.ndarray]:
    """Complex relative gains at modulations in units of ω, and their relative errors, both (n,).

    Raises InputError where marching is not stable or the amplitude would touch the finger.
    """
    if scene.closure() * (1 + depth) >= 1:
        raise InputError(f"point {scene.point_id}: the modulated surface touches the finger")
    first = grid_for(scene, needs_of(scene), tolerance=TOLERANCE)
    second = finer_grid(first)
    if second is None:
        raise InputError(f"point {scene.point_id}: no grid is fine enough for its profile")
    found = [
        _gains(scene, modulations, grid, depth=depth, finer=finer, device=device)
        for grid, finer in ((first, 1.0), (second, 1.5))
    ]
    coarse, fine = np.array(found)
    return fine, np.abs(fine - coarse) / np.abs(fine)


def _gains(
    scene: Scene,
    modulations: np.ndarray,
    grid: Grid,
    *,
    depth: float,
    finer: float,
    device: Device,
) -> np.ndarray:
    """Gains on one grid, each from the last cycle of a march."""
    problems = problems_of([scene, scene], grid, tolerance=TOLERANCE * depth)
    problems.numbers["epsilon"][1] *= -1
    decay = scene.sigma / (pi**2 * (1 + scene.aspect**-2)) / (2 * pi)
    forgotten = ceil(finer * (DECAYS * decay + 3))
    longest = forgotten + ceil(1 / modulations.min())
    if longest > MOST_PERIODS:
        raise InputError(
            f"point {scene.point_id}: a march would take {longest} periods; at most "
            f"{MOST_PERIODS} are allowed"
        )
    steps = steps_for_accuracy(
        epsilon=np.full(2, scene.epsilon),
        sigma=np.full(2, scene.sigma),
        scheme=SCHEME,
        tolerance=TOLERANCE * depth,
    )
    given: dict[str, Any] = {
        "problems": problems,
        "grid": grid,
        "steps_per_period": np.ceil(finer * steps).astype(int),
        "scheme": SCHEME,
        "device": device,
    }
    start = settle(**given)
    if start.status.any():
        raise InputError(f"point {scene.point_id}: marched, it does not settle")
    return np.array(
        [
            _gain(scene, start.overpressure, each, forgotten=forgotten, depth=depth, given=given)
            for each in modulations
        ]
    )


def _gain(
    scene: Scene,
    start: np.ndarray,
    modulation: float,
    *,
    forgotten: int,
    depth: float,
    given: dict[str, Any],
) -> complex:
    """Gain at one modulation, from what is marched after ``forgotten`` periods."""
    cycle = ceil(1 / modulation)
    found = march(
        **given,
        periods=forgotten + cycle,
        overpressure=start,
        modulation=Modulation(depth, modulation),
    )
    if found.status.any():
        raise InputError(f"point {scene.point_id}: {STATUS[found.status.max()]}")
    periods = np.arange(forgotten, forgotten + cycle)
    mean = found.mean_by_period.mean(axis=0)[forgotten:]
    parts, *_ = np.linalg.lstsq(_basis(periods, modulation), mean, rcond=None)
    return complex(parts[1], parts[2]) / (parts[0] * depth)


def _basis(periods: np.ndarray, modulation: float) -> np.ndarray:
    """Means over periods of 1, sin and cos of the modulation's phase and of its harmonics."""
    columns = [np.ones(len(periods))]
    for harmonic in range(1, HARMONICS + 1):
        rate = 2 * pi * modulation * harmonic
        begin, end = rate * periods, rate * (periods + 1)
        columns += [(np.cos(begin) - np.cos(end)) / rate, (np.sin(end) - np.sin(begin)) / rate]
    return np.stack(columns, axis=1)
