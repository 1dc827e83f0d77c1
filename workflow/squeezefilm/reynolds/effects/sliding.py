"""Sliding: the bearing term, and the profile that moves past a finger, which no equation here has.

Both need states beside the scene's own: the finger at rest, or a little further on.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan2, cos, degrees, hypot, radians, sin

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.effects.fields import Fields

# Of the finger's length along x: between the two states whose difference is a derivative.
DISTANCE = 1e-3


def at_rest(scene: Scene) -> Scene:
    """The same finger, not sliding."""
    return replace(scene, finger=replace(scene.finger, speed_x_m_per_s=0.0))


def beside(scene: Scene) -> tuple[Scene, Scene]:
    """The finger half of DISTANCE back and half forward along its own x axis."""
    return _moved(scene, -DISTANCE / 2), _moved(scene, DISTANCE / 2)


def _moved(scene: Scene, share: float) -> Scene:
    turn, length_m = radians(scene.finger.rotation_deg), share * scene.finger.length_x_m
    x_m, y_m = scene.x_m + length_m * cos(turn), scene.y_m + length_m * sin(turn)
    return replace(scene, phi_r_m=hypot(x_m, y_m), phi_deg=degrees(atan2(y_m, x_m)))


def source(back: Fields, forward: Fields) -> np.ndarray:
    """Source of mass of the profile that passes, +2Λ ∂(Hρ)/∂c, on all nodes.

    The bearing number has the speed of the surface past the finger, so the finger's place c on the
    surface falls: its time derivative adds −(2Λ/σ) ∂/∂c to ∂/∂T. Gas that both states bring along
    at another place is what the equation with a standing profile leaves out.
    """
    rate = 2 * forward.numbers("bearing", absent=0.0)
    return np.asarray(-rate * (forward.mass - back.mass) / DISTANCE)
