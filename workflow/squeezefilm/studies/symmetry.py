"""The symmetry of a study's scenes over the finger's position, found from pad and vibration."""

from collections.abc import Iterator
from functools import lru_cache
from math import atan2, cos, degrees, radians, sin

import numpy as np

from squeezefilm.film.directions import Directions, Mirrors, Symmetry
from squeezefilm.film.finger import Finger
from squeezefilm.film.vibration.shapes import Vibration, phasor_of
from squeezefilm.film.vibration.surfaces import Rectangle, Surface

# Places on the surface at which a profile is compared with its image.
PROBES = 4000
EQUAL = 1e-9
"""Values that agree to this, of a maximum of 1, are equal."""


def no_symmetry(surface: Surface) -> Symmetry:
    """That of a film whose positions stand for no others."""
    if isinstance(surface, Rectangle):
        return Mirrors(x=False, y=False)
    return Directions(0.0, 360.0, mirror=False)


@lru_cache(maxsize=16)
def symmetry(finger: Finger, profile: Vibration, *, surface: Surface) -> Symmetry:
    """What the force over the finger's position has in common with pad, profile and surface."""
    if not isinstance(surface, Rectangle):
        return _directions(finger, profile, surface)

    def holds(axis_deg: float) -> bool:
        change = _mirror(axis_deg)
        return _keeps_pad(change, finger) and _keeps_profile(change, profile, surface)

    return Mirrors(x=holds(90), y=holds(0))


def _directions(finger: Finger, profile: Vibration, surface: Surface) -> Directions:
    """The smallest sector found among subgroups of a square's symmetries.

    A mirror or a turn of the finger's centre about the disc's leaves the force as it is where it
    leaves pad, gap at rest and sliding velocity as they are, and the profile too but for its sign:
    s and −s are the same vibration half a period apart. One in two phases may begin at any other
    instant. Symmetries that are not looked for, such as
    those of a circular pad on a profile with three nodal diameters, make the sector larger than it
    need be, never too small.
    """
    sectors = []
    for base_deg in _axes(finger, profile):

        def holds(change: np.ndarray) -> bool:
            return _keeps_pad(change, finger) and _keeps_profile(change, profile, surface)

        mirrors = [base_deg + step for step in (0, 45, 90, 135) if holds(_mirror(base_deg + step))]
        if mirrors:
            width = 180.0 / len(mirrors)
            sectors.append(Directions(min(mirrors) % width, width, mirror=True))
            continue
        turns = [angle for angle in (90.0, 180.0) if holds(_turn(angle))]
        sectors.append(Directions(0.0, min(turns, default=360.0), mirror=False))
    return min(sectors, key=lambda sector: sector.width_deg)


def _axes(finger: Finger, profile: Vibration) -> Iterator[float]:
    """Directions at which an axis of the scene may lie: the pad's; a circle's follow the rest."""
    yield finger.rotation_deg
    if finger.shape == "ellipse" and finger.length_x_m == finger.length_y_m:
        gap = finger.gap
        if gap.tilt_x_m or gap.tilt_y_m:
            yield finger.rotation_deg + degrees(atan2(gap.tilt_y_m, gap.tilt_x_m))
        yield float(getattr(profile, "direction_deg", 0.0))


def _mirror(axis_deg: float) -> np.ndarray:
    twice = 2 * radians(axis_deg)
    return np.array([[cos(twice), sin(twice)], [sin(twice), -cos(twice)]])


def _turn(angle_deg: float) -> np.ndarray:
    c, s = cos(radians(angle_deg)), sin(radians(angle_deg))
    return np.array([[c, -s], [s, c]])


def _keeps_pad(change: np.ndarray, finger: Finger) -> bool:
    """Whether a mirror or turn leaves outline, gap at rest and velocity as they are.

    In the pad's own axes. A bulge has the outline's symmetry: it grows as the same squares.
    """
    if finger.contour:
        return False  # a measured one is its own image under no mirror, nor turn
    turn = _turn(finger.rotation_deg)
    own = turn.T @ change @ turn
    sides = np.array([finger.length_x_m, finger.length_y_m])
    outline = np.diag((sides[0] / sides) ** 2)
    tilt = np.array([finger.gap.tilt_x_m, finger.gap.tilt_y_m]) / sides
    velocity = np.array([finger.speed_x_m_per_s, 0.0])
    return np.allclose(own.T @ outline @ own, outline, rtol=0, atol=EQUAL) and all(
        np.linalg.norm(own @ vector - vector) <= EQUAL * np.linalg.norm(vector)
        for vector in (tilt, velocity)
    )


def _keeps_profile(change: np.ndarray, profile: Vibration, surface: Surface) -> bool:
    x_m, y_m = surface.probes(PROBES)
    image_x_m, image_y_m = change @ np.stack([x_m, y_m])
    s = phasor_of(profile, x_m=x_m, y_m=y_m)
    image = phasor_of(profile, x_m=image_x_m, y_m=image_y_m)
    together = np.vdot(s, image)
    turn = together / abs(together) if together else 1.0
    return bool(np.abs(image - turn * s).max() <= EQUAL)
