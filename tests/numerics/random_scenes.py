"""Random films and scenes, what ``auto`` leaves out of them, and how far answers are off."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from films import PISTON, SINC, film

from squeezefilm.film.positions import cartesian_from_polar
from squeezefilm.film.scene import Scene
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.solution import Derivatives, Outputs

H0_M = (1e-6, 30e-6)
FREQUENCY_HZ = (5e3, 1e5)
EPSILON = (0.01, 0.8)


def random_scenes(
    like: Scene, *, count: int, seed: int, most_reynolds: float, inertia: str, thermal: str = "none"
) -> list[Scene]:
    """Gap, excursion and position are uniform, the frequency is so in its logarithm.

    like: of gas, pad and profile; its surface bounds the positions.
    """
    random = np.random.default_rng(seed)
    farthest_m = min(like.actuator.surface.half_extents_m) - like.pad.max_radius_m
    scenes: list[Scene] = []
    while len(scenes) < count:
        h0_m, epsilon = random.uniform(*H0_M), random.uniform(*EPSILON)
        place = cartesian_from_polar(random.uniform(0, farthest_m), random.uniform(0, 45))
        frequency_hz = math.exp(random.uniform(*np.log(FREQUENCY_HZ)))
        scene = replace(
            like,
            point_id=str(len(scenes) + 1),
            h0_m=h0_m,
            hv_m=epsilon * h0_m,
            **place,
            gas=replace(like.gas, inertia=inertia, thermal=thermal),
            actuator=replace(like.actuator, frequency_hz=frequency_hz),
        )
        if scene.modified_reynolds < most_reynolds:
            scenes.append(scene)
    return scenes


def moved_by_leaving_out(
    scenes: Sequence[Scene], *, term: str, model_tolerance: float
) -> np.ndarray:
    """How far including a term moves the forces of the scenes that ``auto`` leaves it out of.

    term: ``inertia`` or ``thermal``; the other is as ``auto`` has it. Forces are solved to 1e-4.
    """
    choices = resolve_auto_terms(scenes, model_tolerance=model_tolerance, device=choose_device())
    without = [scene for scene in choices if getattr(scene.gas, term) == "none"]
    beside = [each.with_gas(**{term: "included"}) for each in without]
    neglected, included = (
        np.array([each.force_n for each in solve(some, tolerance=1e-4, method="periodic")])
        for some in (without, beside)
    )
    return np.abs(included / neglected - 1)


def random_films(count: int, *, seed: int) -> list[Scene]:
    """Films of all kinds."""
    random = np.random.default_rng(seed)
    return [
        film(
            epsilon=random.uniform(0.01, 0.8),
            sigma=10 ** random.uniform(-0.5, 4.5),
            profile=PISTON if random.random() < 0.2 else SINC,
            x=random.choice([0.0, random.uniform(0, 0.3)]),
            y=random.choice([0.0, random.uniform(0, 0.3)]),
            bearing=random.choice([0.0, 0.0, 10 ** random.uniform(-2, 1.3)]),
            aspect=random.choice([1.0, 10 ** random.uniform(-0.4, 0.4)]),
            rarefaction=str(random.choice(["none", "slip", "fukui-kaneko"])),
            knudsen=10 ** random.uniform(-3, -1.7),
            polytropic_exponent=float(random.choice([1.0, 1.2, 1.4])),
        )
        for _ in range(count)
    ]


def shares(
    some: Sequence[Derivatives | Outputs], closer: Sequence[Derivatives | Outputs]
) -> dict[str, list[float]]:
    """By number, the differences from answers of a tighter tolerance over the errors of both."""
    found = defaultdict(list)
    for a, b in zip(some, closer, strict=True):
        for name in a.value.keys() & b.value.keys():
            if (allowed := a.error[name] + b.error[name]) > 0:
                found[name].append(abs(a.value[name] - b.value[name]) / allowed)
    return found
