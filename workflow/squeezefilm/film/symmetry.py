"""The pad's positions that stand for all others, by a scene's symmetry.

The mean force over the pad's position has the symmetry that pad and vibration share. On a disc
these are mirror axes through the centre, or turns about it, and positions in one sector represent
all; on a rectangle mirrors of its axes, and positions on one side of them do.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import atan2, degrees, isfinite, radians
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError
from squeezefilm.film.outline import DISC_COORDINATES
from squeezefilm.film.pad import Pad
from squeezefilm.film.positions import CARTESIAN_COLUMNS, POLAR_COLUMNS, Positions
from squeezefilm.film.profiles import Profile, narrow_feature_points
from squeezefilm.film.scene import PadPositions
from squeezefilm.film.surfaces import Rectangle, Surface

Array = NDArray[np.float64]

SECTOR_WIDTHS_DEG = (45.0, 90.0, 180.0, 360.0)


@dataclass(frozen=True)
class DirectionSector:
    """A sector of directions, in degrees, whose positions represent all positions.

    It begins at ``start_deg`` and is ``width_deg`` wide, one of SECTOR_WIDTHS_DEG. With ``mirror``
    its edges are mirror axes; without, a turn by its width changes nothing (by 360°: no symmetry).
    """

    start_deg: float
    width_deg: float
    mirror: bool
    position_columns = POLAR_COLUMNS

    @property
    def stop_deg(self) -> float:
        return self.start_deg + self.width_deg

    def fold_directions(self, phi_deg: ArrayLike) -> Array:
        """The directions within the sector that give the same force at the same radius."""
        angle = np.asarray(phi_deg, dtype=float) - self.start_deg
        if not self.mirror:
            return self.start_deg + angle % self.width_deg
        angle = angle % (2 * self.width_deg)
        return self.start_deg + np.minimum(angle, 2 * self.width_deg - angle)

    def equivalent_directions_deg(self, phi_deg: Iterable[float]) -> list[float]:
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
        return sorted({round(float(angle), 9) for angle in (*self.fold_directions(turned), *edges)})

    def representative_positions(self, *, phi_r_m: Array, phi_deg: Array) -> dict[str, Array]:
        """The positions of the same forces that lie in the sector, which has the centre."""
        return {
            "phi_r_m": phi_r_m,
            "phi_deg": np.where(phi_r_m > 0, self.fold_directions(phi_deg), phi_deg),
        }

    def limits(self, positions: Positions) -> dict[str, tuple[float, float]]:
        """The limits of the positions of a study."""
        farthest = float(max(positions.phi_r_m))
        return {"phi_r_m": (0.0, farthest), "phi_deg": (self.start_deg, self.stop_deg)}

    def pad_positions(self, positions: Positions) -> list[tuple[float, float]]:
        """The centre, then every radius with every angle and its images (Fig. 15)."""
        angles = self.equivalent_directions_deg(positions.phi_deg)
        return [(0.0, 0.0), *((r, angle) for r in positions.phi_r_m for angle in angles)]

    @property
    def text(self) -> str:
        """Return a sentence that names the positions that represent all."""
        others = f"turned by {self.width_deg:g} deg"
        if self.mirror:
            others = f"mirrored at {self.start_deg:g} deg and every {self.width_deg:g} on"
        sector = f"{self.start_deg:g} to {self.stop_deg:g} deg"
        return f"Positions are at directions of {sector}, which stand for all: others are {others}."

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        return {"start_deg": self.start_deg, "width_deg": self.width_deg, "mirror": self.mirror}


@dataclass(frozen=True)
class MirrorAxes:
    """Axes of a rectangle that may be mirrored: the force at −x (or −y) is that at x."""

    x: bool
    y: bool
    position_columns = CARTESIAN_COLUMNS

    @property
    def text(self) -> str:
        """Return a sentence that names the positions that represent all."""
        sides = ["x >= 0"] * self.x + ["y >= 0"] * self.y or ["any place"]
        return f"Positions are at {' and '.join(sides)}, which stand for all: the rest is mirrored."

    def representative_positions(self, *, x_m: Array, y_m: Array) -> dict[str, Array]:
        """The positions of the same forces on the sides that stand for all."""
        return {"x_m": np.abs(x_m) if self.x else x_m, "y_m": np.abs(y_m) if self.y else y_m}

    def limits(self, positions: Positions) -> dict[str, tuple[float, float]]:
        """The limits of the positions of a study."""
        x_m, y_m = (float(max(given)) for given in (positions.x_m, positions.y_m))
        least = (0.0 if self.x else -x_m, 0.0 if self.y else -y_m)
        return {"x_m": (least[0], x_m), "y_m": (least[1], y_m)}

    def pad_positions(self, positions: Positions) -> list[tuple[float, float]]:
        """The centre, then every x with every y; those at −x too, or else those on the mirror."""
        x_m, y_m = (
            sorted(
                {0.0, *given} if mirror else {*given, *(0.0 - coordinate for coordinate in given)}
            )
            for given, mirror in ((positions.x_m, self.x), (positions.y_m, self.y))
        )
        return [(0.0, 0.0), *((x, y) for x in x_m for y in y_m if (x, y) != (0.0, 0.0))]

    def to_dict(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        return {"mirror_x": self.x, "mirror_y": self.y}


Symmetry = DirectionSector | MirrorAxes


def symmetry_from_dict(plain: Any, *, source: str) -> Symmetry:
    """Return the symmetry that to_dict wrote; raises InputError for anything else."""
    match plain:
        case {"mirror_x": bool(x), "mirror_y": bool(y)}:
            return MirrorAxes(x, y)
        case {"start_deg": float(start) | int(start), "width_deg": width, "mirror": bool(mirror)}:
            if isfinite(start) and width in SECTOR_WIDTHS_DEG:
                return DirectionSector(float(start), float(width), mirror)
    raise InputError(f"{source}: must have start_deg, width_deg and mirror, as `fit` writes")


SYMMETRY_TOLERANCE = 1e-9
"""Values that agree to this, of a maximum of 1, are equal."""
ROUNDING_TOLERANCE = 1e-13
"""Values of a profile that should agree by symmetry agree to rounding, relative to its largest."""
FIRST_CHECK_POINT_COUNT, CHECK_POINT_COUNT = 16, 1000
"""Points at which a profile is compared: those that most others fail, then all."""
POSITIONS_CHECKED_TOGETHER = 64
"""Positions that are compared together at many points."""


def no_symmetry(surface: Surface) -> Symmetry:
    """Symmetry of a film whose positions stand for no others."""
    if isinstance(surface, Rectangle):
        return MirrorAxes(x=False, y=False)
    return DirectionSector(0.0, 360.0, mirror=False)


@lru_cache(maxsize=16)
def symmetry(pad: Pad, profile: Profile, *, surface: Surface) -> Symmetry:
    """Return the symmetry of the force over the pad's position."""
    if not isinstance(surface, Rectangle):
        return _smallest_direction_sector(pad, profile, surface)
    x, y = (
        _is_unchanged_by_turn(turn, pad, profile, surface, mirror=True) for turn in (180.0, 0.0)
    )
    return MirrorAxes(x, y)


def _smallest_direction_sector(pad: Pad, profile: Profile, surface: Surface) -> DirectionSector:
    """The smallest sector found among subgroups of a square's symmetries.

    A mirror or a turn of the pad's centre about the disc's leaves the force as it is where it
    leaves pad, gap at rest and sliding velocity as they are, and the profile too but for its sign:
    s and −s are the same vibration half a period apart. One with two quadrature components may
    begin at any other instant. Symmetries that are not looked for, such as those of a
    circular pad on a profile with three nodal diameters, make the sector larger than it need be,
    never too small.
    """
    sectors, film = [], (pad, profile, surface)
    for base_deg in _candidate_symmetry_axes_deg(pad, profile):
        axes = [base_deg + step for step in (0, 45, 90, 135)]
        mirrors = [axis for axis in axes if _is_unchanged_by_turn(2 * axis, *film, mirror=True)]
        if mirrors:
            width = 180.0 / len(mirrors)
            sectors.append(DirectionSector(min(mirrors) % width, width, mirror=True))
            continue
        turns = [turn for turn in (90.0, 180.0) if _is_unchanged_by_turn(turn, *film)]
        sectors.append(DirectionSector(0.0, min(turns, default=360.0), mirror=False))
    return min(sectors, key=lambda sector: sector.width_deg)


def _candidate_symmetry_axes_deg(pad: Pad, profile: Profile) -> Iterator[float]:
    """Directions at which an axis of the scene may lie: the pad's; a circle's follow the rest."""
    yield pad.rotation_deg
    if pad.shape == "ellipse" and pad.length_x_m == pad.length_y_m:
        gap = pad.gap
        if gap.tilt_x_m or gap.tilt_y_m:
            yield pad.rotation_deg + degrees(atan2(gap.tilt_y_m, gap.tilt_x_m))
        yield float(getattr(profile, "direction_deg", 0.0))


def _is_unchanged_by_turn(
    turn_deg: float, pad: Pad, profile: Profile, surface: Surface, *, mirror: bool = False
) -> bool:
    """Return whether a turn keeps outline, gap at rest, velocity and vibration as they are.

    With ``mirror`` they are mirrored at the x axis before, so that the axis lies at half the turn.
    A crown has the outline's symmetry: it grows with the squares of x and y over the sides.
    """
    if pad.contour:
        return False  # a measured one is its own image under no mirror, nor turn

    def turned_point(z: Any, angle_deg: float) -> Any:
        return np.exp(1j * radians(angle_deg)) * (np.conj(z) if mirror else z)

    own_deg = turn_deg - 2 * pad.rotation_deg * mirror  # in the pad's own axes
    length_x_m, length_y_m = pad.length_x_m, pad.length_y_m
    longer = 1 - (length_x_m / length_y_m) ** 2
    if abs(np.exp(2j * radians(own_deg)) - 1) * abs(longer) > SYMMETRY_TOLERANCE:
        return False
    tilt = complex(pad.gap.tilt_x_m / length_x_m, pad.gap.tilt_y_m / length_y_m)
    for vector in (tilt, complex(pad.speed_x_m_per_s)):
        if abs(turned_point(vector, own_deg) - vector) > SYMMETRY_TOLERANCE * abs(vector):
            return False
    half_x_m, half_y_m = surface.half_extents_m
    # Over half the surface: no two places are related by symmetry.
    x, y = np.random.default_rng(1).uniform(-1, 1, (2, 5000))
    x_m, y_m = half_x_m * x, half_y_m * y
    on_surface = surface.relative_distance(x_m, y_m) <= 1
    x_m, y_m = x_m[on_surface], y_m[on_surface]
    there = turned_point(x_m + 1j * y_m, turn_deg)
    s = profile.amplitude(x_m=x_m, y_m=y_m)
    s_there = profile.amplitude(x_m=there.real, y_m=there.imag)
    together = np.vdot(s, s_there)
    sign = together / abs(together) if together else 1.0
    return bool(np.abs(s_there - sign * s).max() <= SYMMETRY_TOLERANCE)


def axisymmetric_mask(pad_positions: PadPositions) -> np.ndarray:
    """Return at which positions a film has no angle, so that it is solved along a radius, (n,).

    It is that of a disc at rest, the gap flat or crowned, where the profile is the same all around
    each circle about the disc's centre.
    """
    return pad_positions.compute_cached(_find_axisymmetric_mask)


def _find_axisymmetric_mask(positions: PadPositions) -> np.ndarray:
    pad, same = positions.pad_profile.pad, np.zeros(len(positions.x_m), dtype=bool)
    disc = pad.shape == "ellipse" and pad.length_x_m == pad.length_y_m
    if not disc or pad.gap.tilt_x_m or pad.gap.tilt_y_m or pad.speed_x_m_per_s:
        return same
    draw = np.random.default_rng(1)
    radius = draw.uniform(0, 0.5, CHECK_POINT_COUNT)
    angle, other = draw.uniform(0, 2 * np.pi, (2, CHECK_POINT_COUNT))
    few = (values[:FIRST_CHECK_POINT_COUNT] for values in (radius, angle, other))
    rows = np.flatnonzero(_equal_on_circles_mask(positions, *few))
    for batch in np.array_split(rows, 1 + len(rows) // POSITIONS_CHECKED_TOGETHER):
        same[batch] = _equal_on_circles_mask(positions.subset(batch), radius, angle, other)
    x_m, y_m = narrow_feature_points(positions.pad_profile.profile)
    for row in np.flatnonzero(same).tolist() if len(x_m) else ():
        from_centre = x_m - positions.x_m[row] + 1j * (y_m - positions.y_m[row])
        radius, angle = abs(from_centre) / pad.length_x_m, np.angle(from_centre)
        inside = radius < 0.5
        at = radius[inside], angle[inside] - radians(pad.rotation_deg), other[: inside.sum()]
        same[row] = (
            not inside.any()
            or _equal_on_circles_mask(positions.subset(slice(row, row + 1)), *at)[0]
        )
    return same


def _equal_on_circles_mask(
    pad_positions: PadPositions, radius: np.ndarray, angle: np.ndarray, other: np.ndarray
) -> np.ndarray:
    """Return where a profile has the same values on circles at one angle and another, (n,)."""
    at = DISC_COORDINATES.side_fractions
    with np.errstate(all="ignore"):  # of a profile that has no finite value somewhere
        one, two = (pad_positions.amplitude(*at(0.5 + radius, each)) for each in (angle, other))
        return np.asarray(abs(two - one).max(axis=1) <= ROUNDING_TOLERANCE * abs(one).max(axis=1))
