"""The pad over the surface: its pad's outline and how its gap at rest is shaped."""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import cos, pi, radians, sin
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import ConfigDict

from squeezefilm.film.outline import OUTLINE_SAMPLE_COUNT, Outline, ellipse_outline
from squeezefilm.sections import (
    NOT_GIVEN,
    SECTION_CONFIG,
    BoundedNumber,
    DirectionAngle,
    GapRise,
    InternalAttribute,
    Length,
    Text,
    add_key_meanings,
    error_at_key,
    key_of_name,
)

EDGE_POINT_COUNT = 256

Coordinate = TypeVar("Coordinate", float, np.ndarray)


@dataclass(frozen=True)
class OutlineFile:
    """File of a pad's outline.

    Attributes:
        file: points of the edge (docs/tutorials/your-actuator.md), from the folder of this file
        scatter_m: how far the points may lie off the smooth curve through them; 0 stands for 1e-4
            of the longer side
    """

    __pydantic_config__ = SECTION_CONFIG

    file: Text
    scatter_m: Annotated[float, BoundedNumber("m", 0, 1)] = 0.0


@dataclass(frozen=True)
class GapShape:
    """Deviation of the gap at rest from h0, the gap at the pad's centre; all zero if pad and
    surface are parallel.

    Attributes:
        tilt_x_m: gap at the middle of the side at +x less that at −x
        tilt_y_m: gap at the middle of the side at +y less that at −y
        crown_m: gap at the middle of every side less that at the centre; elsewhere the gap grows by
            crown ((2x/length_x)² + (2y/length_y)²); positive for a pad whose crown is towards the
            surface
    """

    __pydantic_config__ = SECTION_CONFIG

    tilt_x_m: GapRise = 0.0
    tilt_y_m: GapRise = 0.0
    crown_m: GapRise = 0.0

    @property
    def flat(self) -> bool:
        return not (self.tilt_x_m or self.tilt_y_m or self.crown_m)

    def rise_m(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Gap at rest less h0 at positions in [0, 1] across the pad."""
        x, y = x - 0.5, y - 0.5
        tilt: np.ndarray = self.tilt_x_m * x + self.tilt_y_m * y
        return tilt + 4 * self.crown_m * (x**2 + y**2)


SIDE_KEYS = ("length_x_m", "length_y_m")


def _add_circle_to_schema(schema: dict[str, Any], section: type) -> None:
    circle = {"properties": {"shape": {"const": "circle"}}, "required": ["shape"]}
    sides = {"required": list(map(key_of_name, SIDE_KEYS))}
    schema |= {"if": circle, "then": {"required": ["diameter"]}, "else": sides}
    add_key_meanings(schema, section)


PadShape = Literal["rectangle", "ellipse", "circle", "curve"]


@dataclass(frozen=True)
class Pad:
    """The pad.

    It slides along its own x axis at constant speed. The middle of a ``curve`` is the pad's centre;
    its ``contour`` is read from a file.

    Attributes:
        shape: its outline
        length_x_m: the rectangle's side, the ellipse's axis or the curve's extent, along x;
            default: of a circle the diameter; else it must be written
        length_y_m: the same along y; default: the same along y
        diameter_m: of a circle, instead of its lengths
        rotation_deg: by how much its x axis is turned from the actuator's, against the clock
        speed_x_m_per_s: speed at which the surface passes it, along the pad's +x axis; 0 at rest
    """

    __pydantic_config__ = SECTION_CONFIG | ConfigDict(json_schema_extra=_add_circle_to_schema)

    shape: PadShape = field(default="rectangle", kw_only=True)
    diameter_m: Length = field(default=NOT_GIVEN, kw_only=True)
    outline: OutlineFile = field(default=NOT_GIVEN, kw_only=True)
    length_x_m: Length = NOT_GIVEN
    length_y_m: Length = NOT_GIVEN
    rotation_deg: DirectionAngle = field(default=0.0, kw_only=True)
    speed_x_m_per_s: Annotated[float, BoundedNumber("m/s", -10000, 10000)] = 0.0
    gap: GapShape = field(default_factory=GapShape, kw_only=True)
    contour: InternalAttribute[Outline | None] = field(default=None, kw_only=True)

    @property
    def area_m2(self) -> float:
        if outline := self.smooth_outline:
            return outline.area * self.length_x_m**2
        return self.length_x_m * self.length_y_m

    @property
    def max_radius_m(self) -> float:
        """Distance of the outline's farthest point from the pad's centre."""
        return float(np.hypot(*self.edge_points_m().T).max())

    @property
    def smooth_outline(self) -> Outline | None:
        """The outline in conformal coordinates, unless it is a rectangle."""
        if self.shape == "ellipse":
            return ellipse_outline(self.length_y_m / self.length_x_m)
        return self.contour

    def edge_points_m(self) -> np.ndarray:
        """Points on the edge from the pad's centre, along the actuator's axes: (points, 2) in m.

        A rectangle's four corners, or points all around another pad.
        """
        if outline := self.smooth_outline:
            contour = outline.points[:: OUTLINE_SAMPLE_COUNT // EDGE_POINT_COUNT]
            x_m, y_m = contour.real * self.length_x_m, contour.imag * self.length_x_m
        else:
            x_m, y_m = np.array([[-1, 1, 1, -1], [-1, -1, 1, 1]]) / 2
            x_m, y_m = x_m * self.length_x_m, y_m * self.length_y_m
        return np.stack(self.to_actuator_axes(x_m, y_m), axis=1)

    def contains_positions(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return whether positions in [0, 1] across the sides lie under the pad."""
        if self.contour:
            z = (x - 0.5) + 1j * (y - 0.5) * self.contour.aspect
            return self.contour.contains_positions(z.ravel()).reshape(z.shape)
        if self.shape == "ellipse":
            return np.asarray((2 * x - 1) ** 2 + (2 * y - 1) ** 2 <= 1 + 1e-12)
        return np.asarray((np.abs(2 * x - 1) <= 1) & (np.abs(2 * y - 1) <= 1))

    def to_actuator_axes(self, x: Coordinate, y: Coordinate) -> tuple[Coordinate, Coordinate]:
        """Pad's coordinates in those of the actuator's axes."""
        if self.rotation_deg == 0:
            return x, y
        c, s = cos(radians(self.rotation_deg)), sin(radians(self.rotation_deg))
        return c * x - s * y, s * x + c * y


UNIFORM_GAP = GapShape()


def validate_shape_keys(pad: Pad) -> Pad:
    """A pad with the keys of its shape alone; a circle is an ellipse of equal axes."""
    own = {"circle": ("diameter_m",), "curve": (*SIDE_KEYS, "outline")}.get(pad.shape, SIDE_KEYS)
    for name in (*SIDE_KEYS, "diameter_m", "outline"):
        if (getattr(pad, name) is None) == (name in own):
            key, keys = key_of_name(name), ", ".join(map(key_of_name, own))
            text = f"with shape: {pad.shape} give {keys}, not {key}"
            raise error_at_key(text, key, kind="missing" if name in own else "relation")
    if pad.shape != "circle":
        return pad
    return replace(
        pad,
        shape="ellipse",
        diameter_m=NOT_GIVEN,
        length_x_m=pad.diameter_m,
        length_y_m=pad.diameter_m,
    )


@lru_cache(maxsize=256)
def net_points_on_pad(pad: Pad) -> tuple[np.ndarray, np.ndarray]:
    """A net of points x, y over the pad, edge included, in [0, 1]."""
    if outline := pad.smooth_outline:
        across, nu = np.meshgrid(np.linspace(0.5, 1, 11), np.linspace(0, 2 * pi, 97))
        return outline.side_fractions(across, nu)
    x, y = np.meshgrid(*2 * [np.linspace(0, 1, 25)], indexing="ij")
    return x, y
