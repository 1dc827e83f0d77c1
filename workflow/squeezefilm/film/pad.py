"""The finger over the surface: its pad's outline and how its gap at rest is shaped."""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import cos, pi, radians, sin, sqrt
from typing import TypeVar

import numpy as np

from squeezefilm.config.film import GapShape as GapShape
from squeezefilm.film.outline import DENSE, Outline, ellipse

OUTLINE_POINTS = 144
EVEN = GapShape()

Number = TypeVar("Number", float, np.ndarray)


@dataclass(frozen=True)
class Finger:
    """A pad, sliding along its own x axis at constant speed.

    ``length_x_m`` and ``length_y_m`` are the sides of the rectangle, the axes of the ellipse, or
    the extents of a ``curve``, the closed ``contour``, whose middle is the pad's centre; the
    finger's x axis is turned by ``rotation_deg`` from the actuator's, against the clock.
    """

    length_x_m: float
    length_y_m: float
    speed_x_m_per_s: float
    shape: str = "rectangle"
    rotation_deg: float = 0.0
    gap: GapShape = EVEN
    contour: Outline | None = None

    @property
    def area_m2(self) -> float:
        if self.contour:
            return self.contour.area * self.length_x_m**2
        share = pi / 4 if self.shape == "ellipse" else 1.0
        return share * self.length_x_m * self.length_y_m

    @property
    def reach_m(self) -> float:
        """Distance of the outline's farthest point from the finger's centre."""
        return float(np.hypot(*self.outline().T).max())

    @property
    def rectangle_within(self) -> float:
        """Sides of the largest rectangle of its proportions about its centre, over its own."""
        if self.contour:
            rim = self.contour.points
            across = np.maximum(2 * np.abs(rim.real), 2 * np.abs(rim.imag) / self.contour.aspect)
            return float(across.min())
        return sqrt(0.5) if self.shape == "ellipse" else 1.0

    @property
    def smooth_outline(self) -> Outline | None:
        """The outline in conformal coordinates, unless it is a rectangle."""
        if self.contour:
            return self.contour
        return ellipse(self.length_y_m / self.length_x_m) if self.shape == "ellipse" else None

    def outline(self) -> np.ndarray:
        """Points on the rim from the finger's centre, along the actuator's axes: (points, 2) in m.

        A rectangle's four corners, or points all around another pad.
        """
        half_m = np.array([self.length_x_m, self.length_y_m]) / 2
        if self.contour:
            rim = self.contour.points[:: DENSE // (2 * OUTLINE_POINTS)] * self.length_x_m
            points_m = np.stack([rim.real, rim.imag], axis=1)
        elif self.shape == "ellipse":
            angles = 2 * pi * np.arange(OUTLINE_POINTS) / OUTLINE_POINTS
            points_m = half_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        else:
            points_m = half_m * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
        return np.stack(self.turned(*points_m.T), axis=1)

    def within(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Whether places in [0, 1] across the sides lie under the pad."""
        if self.contour:
            z = (x - 0.5) + 1j * (y - 0.5) * self.contour.aspect
            return self.contour.within(z.ravel()).reshape(z.shape)
        if self.shape == "ellipse":
            return np.asarray((2 * x - 1) ** 2 + (2 * y - 1) ** 2 <= 1 + 1e-12)
        return np.asarray((np.abs(2 * x - 1) <= 1) & (np.abs(2 * y - 1) <= 1))

    def turned(self, x: Number, y: Number) -> tuple[Number, Number]:
        """Finger's coordinates in those of the actuator's axes."""
        if self.rotation_deg == 0:
            return x, y
        c, s = cos(radians(self.rotation_deg)), sin(radians(self.rotation_deg))
        return c * x - s * y, s * x + c * y

    def turned_back(self, x: Number, y: Number) -> tuple[Number, Number]:
        """Coordinates along the actuator's axes in the finger's own."""
        return replace(self, rotation_deg=-self.rotation_deg).turned(x, y)


@lru_cache(maxsize=256)
def net(finger: Finger) -> tuple[np.ndarray, np.ndarray]:
    """A net of points x, y over the pad, rim included, in [0, 1]."""
    if finger.contour:
        across, nu = np.meshgrid(np.linspace(0.5, 1, 11), np.linspace(0, 2 * pi, 97))
        return finger.contour.positions(across, nu)
    if finger.shape == "ellipse":
        r, angle = np.meshgrid(np.linspace(0, 0.5, 11), np.linspace(0, 2 * pi, 49))
        return 0.5 + r * np.cos(angle), 0.5 + r * np.sin(angle)
    side = np.linspace(0, 1, 25)
    x, y = np.meshgrid(side, side, indexing="ij")
    return x, y
