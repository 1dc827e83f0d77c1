"""The pad over the surface: its pad's outline and how its gap at rest is shaped."""

from dataclasses import dataclass
from functools import lru_cache
from math import cos, pi, radians, sin
from typing import TypeVar

import numpy as np

from squeezefilm.config.film import GapShape as GapShape
from squeezefilm.film.outline import DENSE, Outline, ellipse

OUTLINE_POINTS = 256
EVEN = GapShape()

Number = TypeVar("Number", float, np.ndarray)


@dataclass(frozen=True)
class Pad:
    """A pad, sliding along its own x axis at constant speed.

    ``length_x_m`` and ``length_y_m`` are the sides of the rectangle, the axes of the ellipse, or
    the extents of a ``curve``, the closed ``contour``, whose middle is the pad's centre; the
    pad's x axis is turned by ``rotation_deg`` from the actuator's, against the clock.
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
        if outline := self.smooth_outline:
            return outline.area * self.length_x_m**2
        return self.length_x_m * self.length_y_m

    @property
    def reach_m(self) -> float:
        """Distance of the outline's farthest point from the pad's centre."""
        return float(np.hypot(*self.outline().T).max())

    @property
    def smooth_outline(self) -> Outline | None:
        """The outline in conformal coordinates, unless it is a rectangle."""
        if self.shape == "ellipse":
            return ellipse(self.length_y_m / self.length_x_m)
        return self.contour

    def outline(self) -> np.ndarray:
        """Points on the rim from the pad's centre, along the actuator's axes: (points, 2) in m.

        A rectangle's four corners, or points all around another pad.
        """
        if outline := self.smooth_outline:
            rim = outline.points[:: DENSE // OUTLINE_POINTS]
            x_m, y_m = rim.real * self.length_x_m, rim.imag * self.length_x_m
        else:
            x_m, y_m = np.array([[-1, 1, 1, -1], [-1, -1, 1, 1]]) / 2
            x_m, y_m = x_m * self.length_x_m, y_m * self.length_y_m
        return np.stack(self.turned(x_m, y_m), axis=1)

    def within(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return whether positions in [0, 1] across the sides lie under the pad."""
        if self.contour:
            z = (x - 0.5) + 1j * (y - 0.5) * self.contour.aspect
            return self.contour.within(z.ravel()).reshape(z.shape)
        if self.shape == "ellipse":
            return np.asarray((2 * x - 1) ** 2 + (2 * y - 1) ** 2 <= 1 + 1e-12)
        return np.asarray((np.abs(2 * x - 1) <= 1) & (np.abs(2 * y - 1) <= 1))

    def turned(self, x: Number, y: Number) -> tuple[Number, Number]:
        """Pad's coordinates in those of the actuator's axes."""
        if self.rotation_deg == 0:
            return x, y
        c, s = cos(radians(self.rotation_deg)), sin(radians(self.rotation_deg))
        return c * x - s * y, s * x + c * y


@lru_cache(maxsize=256)
def net(pad: Pad) -> tuple[np.ndarray, np.ndarray]:
    """A net of points x, y over the pad, rim included, in [0, 1]."""
    if outline := pad.smooth_outline:
        across, nu = np.meshgrid(np.linspace(0.5, 1, 11), np.linspace(0, 2 * pi, 97))
        return outline.positions(across, nu)
    x, y = np.meshgrid(*2 * [np.linspace(0, 1, 25)], indexing="ij")
    return x, y
