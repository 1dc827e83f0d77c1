"""Sliding: the bearing term, and the profile that moves past a finger, which no equation here has.

Both need states beside the scene's own: the finger at rest, or a little further on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import cos, radians, sin

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.effects.fields import Fields
from squeezefilm.reynolds.effects.sensitivity import curvature_of_flow, response

# Of the finger's length along x, from one state to the next whose differences are derivatives.
STEP = 5e-3
# Preconditioned residual over its size at the start, of what is differentiated once more.
TOLERANCE = 1e-7


def at_rest(scene: Scene) -> Scene:
    """The same finger, not sliding."""
    return replace(scene, finger=replace(scene.finger, speed_x_m_per_s=0.0))


def line(scene: Scene) -> list[Scene]:
    """The finger at five places a STEP apart along its own x axis, its own the middle one."""
    return [_moved(scene, STEP * steps) for steps in range(-2, 3)]


def _moved(scene: Scene, share: float) -> Scene:
    turn, length_m = radians(scene.finger.rotation_deg), share * scene.finger.length_x_m
    x_m, y_m = scene.x_m + length_m * cos(turn), scene.y_m + length_m * sin(turn)
    return replace(scene, x_m=x_m, y_m=y_m)


def change_by_passing(
    films: Sequence[Fields], *, bearing: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """First and second order of the mean pressure's change by the profile that passes.

    The bearing number Λ has the speed of the surface past the finger, whose place c on the surface
    therefore falls, by 2Λ/σ per T. ∂/∂T of the film seen from the finger is then ∂/∂T − (2Λ/σ)
    ∂/∂c, the second part of which is left out for a profile that stands. To second order, since at
    the middle of a symmetric profile the first vanishes:

        J w1 = −2Λ ∂(Hρ)/∂c,     J w2 = −2Λ ∂w1/∂c − ½ R''(w1, w1).

    Args:
        films: at the places of ``line``, of an isothermal gas.
        bearing: Λ of each scene.

    Returns:
        Both orders, each of shape (scenes,).
    """
    rate = -films[2].number(bearing) / STEP

    def first(k: int) -> np.ndarray:
        pushed = rate * (films[k + 1].mass - films[k - 1].mass)[films[k].inner]
        return response(films[k], pushed, tolerance=TOLERANCE)

    back, here, forward = first(1), first(2), first(3)
    middle = films[2]
    rise = middle.with_rim(here) / (middle.gap * middle.density_slope)
    curved = curvature_of_flow(middle, rise)[middle.inner]
    second = response(middle, rate * (forward - back) - curved, tolerance=TOLERANCE)

    def mean_of(mass: np.ndarray) -> np.ndarray:
        return middle.mean(middle.with_rim(mass) / (middle.gap * middle.density_slope))

    return mean_of(here), mean_of(second)
