"""The directions from an actuator's centre that stand for all others, by a scene's symmetry.

The mean force over the finger's position has the symmetry that pad and vibration share: mirror
axes through the centre, or turns about it. Positions in one sector then represent all.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.io.errors import InputError

Array = NDArray[np.float64]

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
