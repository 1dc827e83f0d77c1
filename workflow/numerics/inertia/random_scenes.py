"""Forces with inertia on random scenes: are they as good as they say, and what do they cost?

Every force is held against that of the same equation on a finer grid, whose tolerance is tighter.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.positions import cartesian
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.effects.automatic import decided

H0_M = (1e-6, 30e-6)
FREQUENCY_HZ = (5e3, 1e5)
EPSILON = (0.01, 0.8)
# The reference's tolerance over that of the forces.
TIGHTER = 0.1


@dataclass(frozen=True)
class Found:
    """What became of some scenes at a tolerance.

    Attributes:
        refused: scenes without a force.
        unknown: scenes with a force whose reference was refused.
        covered: share of the forces with a reference whose error is within their estimate.
        worst_error: largest relative error.
        worst_share: largest error over its estimate.
        outside: forces that are off by more than the tolerance.
        cpu_seconds: processor time of all threads.
    """

    tolerance: float
    scenes: int
    refused: int
    unknown: int
    covered: float
    worst_error: float
    worst_share: float
    outside: int
    cpu_seconds: float


def random_scenes(
    like: Scene,
    *,
    count: int,
    seed: int,
    reynolds: tuple[float, float],
    inertia: str,
    heat: str = "none",
) -> list[Scene]:
    """Scenes over gap, frequency, excursion and position, of a Re between two.

    Gap, excursion and position are uniform, the frequency is so in its logarithm.

    Args:
        like: of gas, finger and profile; its surface bounds the positions.
    """
    random = np.random.default_rng(seed)
    finger = like.finger
    farthest_m = min(like.actuator.surface.half_m) - finger.reach_m
    scenes: list[Scene] = []
    while len(scenes) < count:
        h0_m = random.uniform(*H0_M)
        epsilon = random.uniform(*EPSILON)
        place = cartesian(random.uniform(0, farthest_m), random.uniform(0, 45))
        scene = replace(
            like,
            point_id=str(len(scenes) + 1),
            h0_m=h0_m,
            hv_m=epsilon * h0_m,
            x_m=place["x_m"],
            y_m=place["y_m"],
            gas=replace(like.gas, inertia=inertia, heat=heat),
            actuator=replace(
                like.actuator,
                frequency_hz=math.exp(random.uniform(*np.log(FREQUENCY_HZ))),
            ),
        )
        if reynolds[0] <= scene.modified_reynolds < reynolds[1]:
            scenes.append(scene)
    return scenes


def against_a_finer_grid(
    scenes: Sequence[Scene], *, tolerance: float, device: Device
) -> tuple[Found, list[Solution], list[Solution]]:
    """The scenes' forces beside those at a tolerance of TIGHTER times as much."""
    begin = time.process_time()
    solved = solve(scenes, tolerance=tolerance, method="periodic", device=device)
    cpu = time.process_time() - begin
    exact = solve(scenes, tolerance=TIGHTER * tolerance, method="periodic", device=device)
    force, estimate = _forces(solved)
    reference, _ = _forces(exact)
    known = np.isfinite(force) & np.isfinite(reference)
    error = np.abs(force - reference)[known]
    relative = error / np.abs(reference[known])
    found = Found(
        tolerance=tolerance,
        scenes=len(scenes),
        refused=int(np.isnan(force).sum()),
        unknown=int((np.isfinite(force) & np.isnan(reference)).sum()),
        covered=float(np.mean(error <= estimate[known])),
        worst_error=float(relative.max()),
        worst_share=float((error / estimate[known]).max()),
        outside=int((relative > tolerance).sum()),
        cpu_seconds=cpu,
    )
    return found, solved, exact


def moved_by_leaving_out(
    scenes: Sequence[Scene],
    *,
    term: str = "inertia",
    model_tolerance: float,
    tolerance: float,
    device: Device,
) -> tuple[int, np.ndarray]:
    """How many scenes a term is left out of by ``auto``, and how far including it moves theirs.

    Args:
        term: ``inertia`` or ``heat``; the other is as ``auto`` has it.

    Returns:
        The number, and the relative changes of those whose force with inertia is known.
    """
    choices = decided(scenes, model_tolerance=model_tolerance, device=device)
    without = [scene for scene in choices if getattr(scene.gas, term) == "none"]
    choice: dict[str, Any] = {term: "included"}
    beside = [replace(each, gas=replace(each.gas, **choice)) for each in without]
    forces = [
        _forces(solve(some, tolerance=tolerance, method="periodic", device=device))[0]
        for some in (without, beside)
    ]
    change = np.abs(forces[1] / forces[0] - 1)
    return len(without), change[np.isfinite(change)]


def _forces(solutions: Sequence[Solution]) -> tuple[np.ndarray, np.ndarray]:
    """Forces and their errors; ``nan`` for a force that was refused."""
    refused = [each.status != "ok" for each in solutions]
    force = np.array([each.force_n for each in solutions])
    error = np.array([each.force_error_n for each in solutions])
    return np.where(refused, np.nan, force), np.where(refused, np.nan, error)
