"""The finger's positions that stand for all others, by a scene's symmetry.

The mean force over the finger's position has the symmetry that pad and vibration share. On a disc
these are mirror axes through the centre, or turns about it, and positions in one sector represent
all; on a rectangle mirrors of its axes, and positions on one side of them do.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import CARTESIAN, POLAR

Array = NDArray[np.float64]

Positions = Mapping[str, Sequence[float]]
"""A study's section ``positions``."""

WIDTHS_DEG = (45.0, 90.0, 180.0, 360.0)


@dataclass(frozen=True)
class Directions:
    """A sector of directions, in degrees, whose positions represent all positions.

    It begins at ``start_deg`` and is ``width_deg`` wide, one of WIDTHS_DEG. With ``mirror`` its
    edges are mirror axes; without, a turn by its width changes nothing (by 360°: no symmetry).
    """

    start_deg: float
    width_deg: float
    mirror: bool
    position = POLAR

    @property
    def stop_deg(self) -> float:
        return self.start_deg + self.width_deg

    @property
    def because(self) -> str:
        """The symmetry in words."""
        if self.mirror:
            axes = round(180 / self.width_deg)
            count = f"{axes} mirror axes" if axes > 1 else "one mirror axis"
            return f"pad and vibration share {count}, at {self.start_deg:g}°" + (
                f" and every {self.width_deg:g}° on" if axes > 1 else ""
            )
        if self.width_deg < 360:
            return f"pad and vibration are the same turned by {self.width_deg:g}°"
        return "pad and vibration share no symmetry"

    def fold(self, phi_deg: ArrayLike) -> Array:
        """The directions within the sector that give the same force at the same radius."""
        angle = np.asarray(phi_deg, dtype=float) - self.start_deg
        if not self.mirror:
            return self.start_deg + angle % self.width_deg
        angle = angle % (2 * self.width_deg)
        return self.start_deg + np.minimum(angle, 2 * self.width_deg - angle)

    def images(self, phi_deg: Iterable[float]) -> list[float]:
        """The directions that some stand for by a square's symmetry, as far as they differ here.

        Mirrored at the sector's start and every 45° on, folded into the sector, each once and in
        order; its edges are always among them.
        """
        turned = [
            self.start_deg + sign * (angle - self.start_deg) + turn
            for angle in phi_deg
            for sign in (1, -1)
            for turn in range(0, 360, 90)
        ]
        edges = [self.start_deg, *([self.stop_deg] if self.mirror else [])]
        # Nine digits: two ways to the same image differ by rounding.
        return sorted({round(float(angle), 9) for angle in (*self.fold(turned), *edges)})

    def represent(self, *, phi_r_m: Array, phi_deg: Array) -> dict[str, Array]:
        """The positions of the same forces that lie in the sector; the centre is in all."""
        return {"phi_r_m": phi_r_m, "phi_deg": np.where(phi_r_m > 0, self.fold(phi_deg), phi_deg)}

    def limits(self, positions: Positions) -> dict[str, tuple[float, float]]:
        """The limits of the positions of a study."""
        farthest = float(max(positions["phi_r_m"]))
        return {"phi_r_m": (0.0, farthest), "phi_deg": (self.start_deg, self.stop_deg)}

    def places(self, positions: Positions) -> list[tuple[float, float]]:
        """The centre, then every radius with every angle and its images (Fig. 15)."""
        angles = self.images(positions["phi_deg"])
        return [(0.0, 0.0), *((r, angle) for r in positions["phi_r_m"] for angle in angles)]

    @property
    def text(self) -> str:
        """Which positions stand for all, in a sentence."""
        return (
            f"Positions are at directions of {self.start_deg:g} to {self.stop_deg:g} deg, which "
            f"stand for all: {self.because.replace('°', ' deg')}."
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        return {"start_deg": self.start_deg, "width_deg": self.width_deg, "mirror": self.mirror}

    @classmethod
    def from_dict(cls, plain: Any, *, place: str) -> Directions:
        """What to_dict wrote; raises InputError, naming the place, for anything else."""
        try:
            found = cls(float(plain["start_deg"]), float(plain["width_deg"]), plain["mirror"])
        except (KeyError, TypeError, ValueError):
            found = None
        if (
            found is None
            or found.width_deg not in WIDTHS_DEG
            or not np.isfinite(found.start_deg)
            or not isinstance(found.mirror, bool)
        ):
            raise InputError(f"{place}: must have start_deg, width_deg and mirror, as `fit` writes")
        return found


@dataclass(frozen=True)
class Mirrors:
    """Which of the axes of a rectangle may be mirrored: the force at −x (or −y) is that at x."""

    x: bool
    y: bool
    position = CARTESIAN

    @property
    def text(self) -> str:
        """Which positions stand for all, in a sentence."""
        sides = [f"{axis} >= 0" for axis in ("x", "y") if getattr(self, axis)]
        if not sides:
            return "No positions stand for others: pad and vibration share no mirror axis."
        return f"Positions are at {' and '.join(sides)}, which stand for all: the rest is mirrored."

    def represent(self, *, x_m: Array, y_m: Array) -> dict[str, Array]:
        """The positions of the same forces on the sides that stand for all."""
        return {"x_m": np.abs(x_m) if self.x else x_m, "y_m": np.abs(y_m) if self.y else y_m}

    def limits(self, positions: Positions) -> dict[str, tuple[float, float]]:
        """The limits of the positions of a study."""
        farthest = {name: float(max(positions[name])) for name in self.position}
        return {
            "x_m": (0.0 if self.x else -farthest["x_m"], farthest["x_m"]),
            "y_m": (0.0 if self.y else -farthest["y_m"], farthest["y_m"]),
        }

    def places(self, positions: Positions) -> list[tuple[float, float]]:
        """The centre, then every x with every y; those at −x too, or else those on the mirror."""
        x_m, y_m = (
            sorted(
                {0.0, *given}
                if mirror
                else {sign * each + 0.0 for each in given for sign in (1, -1)}
            )
            for given, mirror in ((positions["x_m"], self.x), (positions["y_m"], self.y))
        )
        return [(0.0, 0.0), *((x, y) for x in x_m for y in y_m if (x, y) != (0.0, 0.0))]

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        return {"mirror_x": self.x, "mirror_y": self.y}


Symmetry = Directions | Mirrors


def symmetry_from_dict(plain: Any, *, place: str) -> Symmetry:
    """What to_dict wrote; raises InputError, naming the place, for anything else."""
    if isinstance(plain, dict) and set(plain) == {"mirror_x", "mirror_y"}:
        found = Mirrors(plain["mirror_x"], plain["mirror_y"])
        if isinstance(found.x, bool) and isinstance(found.y, bool):
            return found
    return Directions.from_dict(plain, place=place)
