"""Vibration profiles of an actuator's surface: s(x, y), by formula or as measured.

A point of the surface moves by hv · Im(s e^(iωt)), and the largest |s| on the surface is 1. Where
all of it moves in one phase s is real; of two quadrature components, such as those of a travelling
wave, it is complex.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from math import cos, inf, isfinite, pi, radians, remainder, sin
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AfterValidator, Field, GetPydanticSchema, PlainSerializer, StrictBool

from squeezefilm.errors import InputError
from squeezefilm.film.surfaces import Disc, ModeOrders, Surface
from squeezefilm.formulas import Expression, parse_constants, parse_formula
from squeezefilm.sections import (
    SECTION_CONFIG,
    BoundedNumber,
    DirectionAngle,
    InternalAttribute,
    Length,
    Text,
)

UNBOUNDED_SURFACE = Disc(inf)
# A phase whose sine is itself, in place of zero.
TINY_PHASE = 1e-20
# Values of modes, points times modes, that are kept to be used again: 8 MB.
MAX_CACHED_MODE_VALUES = 1_000_000


class Profile:
    """A vibration over the actuator's surface; ``kind`` is its name in a study."""

    kind: str

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """s at points of any common shape."""
        raise NotImplementedError

    def on_surface(self, surface: Surface) -> Self:
        """The vibration of a surface, over which it has its maximum.

        Raises InputError for a formula or a mode that has none, naming the place.
        """
        if not hasattr(self, "surface"):
            return self
        profile = replace(self, surface=surface)  # type: ignore[type-var]
        if isinstance(profile, BesselMode | Formula):
            largest_unscaled_magnitude(profile)
        return profile

    @cached_property
    def is_complex(self) -> bool:
        """Return whether the amplitudes are complex (two quadrature components)."""
        return np.iscomplexobj(self.amplitude(x_m=np.zeros(1), y_m=np.zeros(1)))


@dataclass(frozen=True)
class Sinc(Profile):
    """s = sin(πkr)/(πkr), the paper's eq. (2) with k = 109.8 per metre (MATLAB's sinc).

    Attributes:
        wave_number_per_m: k, with r from the centre
    """

    __pydantic_config__ = SECTION_CONFIG

    kind: Literal["sinc"] = field(default="sinc", kw_only=True)
    wave_number_per_m: Annotated[float, BoundedNumber("1/m", 0, 1e6, open=True)]

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        # In place, and a root for np.hypot: twice as fast, and most of what batches ask of a host.
        phase = np.asarray(x_m**2 + y_m**2)
        np.sqrt(phase, out=phase)
        phase *= np.pi * self.wave_number_per_m
        np.maximum(phase, TINY_PHASE, out=phase)
        return np.sin(phase) / phase


@dataclass(frozen=True)
class Piston(Profile):
    """s = 1: a flat surface that moves as a whole, the case of the paper's eq. (6)."""

    __pydantic_config__ = SECTION_CONFIG

    kind: Literal["piston"] = field(default="piston", kw_only=True)

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return np.ones(np.broadcast(x_m, y_m).shape)


@dataclass(frozen=True)
class StandingWave(Profile):
    """s ~ cos(2π u/λ), u the distance along ``direction_deg`` from a crest at ``crest_m``.

    Over its largest magnitude on the surface, which is below the crest's where no crest or trough
    lies on it; on one without bounds, if it is not given.

    Attributes:
        wavelength_m: λ
        direction_deg: direction of the wave, from the x axis
        crest_m: how far a crest lies from the centre; it may lie off the surface, the largest
            amplitude on which is 1
    """

    __pydantic_config__ = SECTION_CONFIG

    kind: Literal["standing-wave"] = field(default="standing-wave", kw_only=True)
    wavelength_m: Length
    direction_deg: DirectionAngle = 0.0
    crest_m: Annotated[float, BoundedNumber("m", -10, 10)] = 0.0
    surface: InternalAttribute[Surface] = UNBOUNDED_SURFACE

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        along = x_m * cos(radians(self.direction_deg)) + y_m * sin(radians(self.direction_deg))
        wave: np.ndarray = np.cos(2 * pi * (along - self.crest_m) / self.wavelength_m)
        # How far the surface ends before the crest or trough that is nearest, as a phase.
        reach = 2 * pi * self.surface.extent_along_m(self.direction_deg) / self.wavelength_m
        before = abs(remainder(2 * pi * self.crest_m / self.wavelength_m, pi)) - reach
        return wave / cos(max(before, 0.0))


@dataclass(frozen=True)
class TravellingWave(Profile):
    """s = e^(−2πi u/λ), u the distance along ``direction_deg``: it travels towards larger u.

    Attributes:
        wavelength_m: λ
        direction_deg: direction in which it travels, from the x axis
    """

    __pydantic_config__ = SECTION_CONFIG

    kind: Literal["travelling-wave"] = field(default="travelling-wave", kw_only=True)
    wavelength_m: Length
    direction_deg: DirectionAngle = 0.0

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        # sin T cos ku − cos T sin ku = sin(T − ku)
        first = StandingWave(self.wavelength_m, self.direction_deg)
        second = replace(first, crest_m=-self.wavelength_m / 4)
        return first.amplitude(x_m=x_m, y_m=y_m) + 1j * second.amplitude(x_m=x_m, y_m=y_m)


@dataclass(frozen=True)
class BesselMode(Profile):
    """A disc's bending mode, s ~ [J_n(kr) + c I_n(kr)] cos n(φ − φ0), over its largest magnitude.

    n is the number of nodal diameters, k the bending wave number and c, zero for a membrane, the
    share of the edge's near field (Leissa, Vibration of Plates, 1969, eq. 2.1).

    Attributes:
        nodal_diameters: n
        wave_number_rad_per_m: k
        edge_share: c, amplitude of the near field of the disc's edge; 0 for none
        direction_deg: φ0, direction of an antinode, from the x axis
    """

    __pydantic_config__ = SECTION_CONFIG

    kind: Literal["bessel"] = field(default="bessel", kw_only=True)
    nodal_diameters: Annotated[int, Field(strict=True, ge=0, le=20)]
    wave_number_rad_per_m: Annotated[float, BoundedNumber("rad/m", 0, 1e6, open=True)]
    edge_share: Annotated[float, BoundedNumber("1", -1e6, 1e6)] = 0.0
    direction_deg: DirectionAngle = 0.0
    surface: InternalAttribute[Surface] = UNBOUNDED_SURFACE

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        angle = np.arctan2(y_m, x_m) - radians(self.direction_deg)
        around = np.cos(self.nodal_diameters * angle)
        return self.unscaled_amplitude(x_m, y_m) * around / largest_unscaled_magnitude(self)

    def unscaled_amplitude(self, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """The mode along the direction of an antinode, before it is scaled."""
        from scipy.special import iv, jv

        phase = self.wave_number_rad_per_m * np.hypot(x_m, y_m)
        mode: np.ndarray = jv(self.nodal_diameters, phase)
        return mode + self.edge_share * iv(self.nodal_diameters, phase) if self.edge_share else mode


# A mapping in a study; in a profile, which is hashable, its items.
Constants = Annotated[
    tuple[tuple[str, str | float], ...],
    GetPydanticSchema(lambda _, schema: schema(dict[str, str | float])),
    AfterValidator(lambda values: tuple(values.items())),
    PlainSerializer(dict),
]


@dataclass(frozen=True)
class Formula(Profile):
    """An expression in x, y, r (metres) and phi (radians), over its largest magnitude.

    Attributes:
        expression: arithmetic on `x`, `y`, `r` (m), `phi` (rad) and `pi`: + - * / **, sqrt, exp,
            log, sin, cos, tan, sinh, cosh, tanh, atan, abs, sinc. Divided by its largest magnitude
            on the surface
        quadrature: the same for what moves a quarter of a period ahead: the surface goes down by
            expression · sin ωt + quadrature · cos ωt, over the largest root of both squares on the
            surface; 0 where all moves in one phase
        constants: names of numbers with their units, such as `{wavelength: 12 mm}`, for both
    """

    __pydantic_config__ = SECTION_CONFIG

    kind: Literal["formula"] = field(default="formula", kw_only=True)
    expression: Text
    surface: InternalAttribute[Surface] = UNBOUNDED_SURFACE
    quadrature: Text = "0"
    constants: Constants = ()

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return self.unscaled_amplitude(x_m, y_m) / largest_unscaled_magnitude(self)

    def unscaled_amplitude(self, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """The expressions' value."""
        x, y = np.broadcast_arrays(x_m, y_m)
        coordinates = {"x": x, "y": y, "r": np.hypot(x, y), "phi": np.arctan2(y, x)}
        value = _parsed_expression(self.expression, self.constants).evaluate(**coordinates)
        if self.quadrature != "0":
            value = value + 1j * _parsed_expression(self.quadrature, self.constants).evaluate(
                **coordinates
            )
        return np.broadcast_to(value, x.shape)


@dataclass(frozen=True)
class ModeSum(Profile):
    """A sum of smooth modes on the surface: a measured profile, smoothed (measured/smooth.py).

    ``orders`` are the modes' two numbers (surfaces.py). ``largest`` is the largest magnitude on
    the surface: above 1 by what noise has put on the maximum.
    """

    orders: ModeOrders
    coefficients: tuple[complex, ...]
    surface: Surface
    largest_magnitude: float = 1.0

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        x, y = np.broadcast_arrays(x_m, y_m)
        coefficients = np.array(self.coefficients)
        if x.size * len(self.orders) > MAX_CACHED_MODE_VALUES:
            return self.surface.sum_of_modes_at(self.orders, coefficients, x, y)
        modes = _cached_modes(self.surface, self.orders, x.shape, x.tobytes(), y.tobytes())
        return modes @ coefficients


@lru_cache(maxsize=16)
def _cached_modes(
    surface: Surface, orders: ModeOrders, shape: tuple[int, ...], x_m: bytes, y_m: bytes
) -> np.ndarray:
    """The modes at points given as bytes: profiles with other noise are asked at the same ones."""
    return surface.modes_at(orders, *(np.frombuffer(at).reshape(shape) for at in (x_m, y_m)))


@dataclass(frozen=True)
class QuadratureProfile(Profile):
    """s = a s₁ + i b s₂: two components a quarter of a period apart, the second one ahead.

    ``component_factors`` are a and b, such that the largest |s| on the surface is 1.
    """

    first: Profile
    second: Profile
    component_factors: tuple[float, float] = (1.0, 1.0)

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        first = self.first.amplitude(x_m=x_m, y_m=y_m)
        second = self.second.amplitude(x_m=x_m, y_m=y_m)
        return self.component_factors[0] * first + 1j * (self.component_factors[1] * second)


Coordinate = Annotated[float, BoundedNumber("m", -10, 10)]


@dataclass(frozen=True)
class ScanFile:
    """A measured shape, which is smoothed into ``ModeSum`` (measured/smooth.py).

    Attributes:
        file: a vibrometer's table (docs/reference/scan-files.md), from the folder of this file
        axisymmetric: `true` if the shape depends on the distance from the centre alone; `false`
            leaves it free, and is what a rectangle needs
        along: of a rectangle `x` if the shape is the same at every y, `y` if at every x: points on
            a line will do
        sign: with `measured` a scan without phase and sign is invalid, for it is rectified at
            a node line; `unknown` takes it as it is, with a note at every force
        rows: `COLUMN = VALUE`, the rows of one measurement where the table has several (a drive
            voltage); several conditions have semicolons between. Of a frequency column the rows at
            `actuator.frequency` are taken without; `mode = NUMBER` of a universal file
        origin_m: the centre of the surface in the coordinates of the file
        scale: with `surface` an amplitude is that at the maximum of the surface; with `measured` at
            that of the measured points, beyond which it may be larger
    """

    __pydantic_config__ = SECTION_CONFIG

    kind: Literal["measured"] = field(default="measured", kw_only=True)
    file: Text
    axisymmetric: StrictBool = False
    along: Literal["", "x", "y"] = ""
    sign: Literal["measured", "unknown"] = "measured"
    rows: str = ""
    origin_m: tuple[Coordinate, Coordinate] = (0.0, 0.0)
    scale: Literal["surface", "measured"] = "surface"


ProfileOfStudy = Sinc | Piston | StandingWave | TravellingWave | BesselMode | Formula | ScanFile
"""The profiles that a study can have."""


# Spacing of the nets around a maximum, of half the surface, from the first to the last.
# What a larger value is larger by at least, relative.
FIRST_NET_SPACING, LAST_SEARCH_SPACING, ROUND_OFF = 0.01, 1e-6, 1e-13


def largest_magnitude(
    shape: Callable[[np.ndarray, np.ndarray], np.ndarray], *, surface: Surface
) -> float:
    """Largest |shape(x_m, y_m)| on the surface: the best of a net, then of ever finer ones there.

    NaN when the shape is not finite everywhere on the net.
    """
    half_m = np.array(surface.half_extents_m)

    def magnitude_at(at: np.ndarray) -> np.ndarray:
        """Values at scaled points, shape (2, …); points off the surface are moved onto its edge."""
        x_m, y_m = at / np.maximum(surface.relative_distance(*(at.T * half_m).T), 1)
        return np.abs(shape(x_m * half_m[0], y_m * half_m[1]))

    x_m, y_m, _ = surface.net_points_and_weights(finer=True)
    net = np.stack([x_m.ravel(), y_m.ravel()]) / half_m[:, None]
    with np.errstate(all="ignore"):
        sizes = magnitude_at(net)
    if not np.all(np.isfinite(sizes)):
        return np.nan
    best, largest, spacing = net[:, np.argmax(sizes)], float(sizes.max()), FIRST_NET_SPACING
    around = np.stack(np.meshgrid(*2 * [np.arange(-2.0, 3.0)])).reshape(2, -1)
    while spacing > LAST_SEARCH_SPACING:
        near = best[:, None] + spacing * around
        with np.errstate(all="ignore"):
            sizes = np.nan_to_num(magnitude_at(near), nan=0.0, posinf=0.0)
        k = int(np.argmax(sizes))
        larger = sizes[k] > (1 + ROUND_OFF) * largest
        if larger:
            best, largest = near[:, k], float(sizes[k])
        # From its rim the net moves on.
        spacing /= 1 if larger and np.abs(around[:, k]).max() == 2 else 3
    return largest


@lru_cache(maxsize=16)
def _parsed_expression(
    expression: str, constants: tuple[tuple[str, str | float], ...]
) -> Expression:
    place, names = "actuator.profile", ("x", "y", "r", "phi")
    return parse_formula(
        expression,
        names=names,
        source=f"{place}.expression",
        constants=parse_constants(dict(constants), names=names, source=place, angles_rad=True),
    )


@lru_cache(maxsize=16)
def largest_unscaled_magnitude(profile: BesselMode | Formula) -> float:
    """Largest magnitude on the surface before the profile is scaled to 1.

    Raises InputError where it is not finite, or zero.
    """
    size = largest_magnitude(profile.unscaled_amplitude, surface=profile.surface)
    if not (isfinite(size) and size):
        kind = "formula" if isinstance(profile, Formula) else "bessel"
        raise InputError(
            f"actuator.profile: the {kind} has no finite value everywhere on the "
            f"{profile.surface.text}, or is zero on all of it"
        )
    return size


# A formula may hide a spot too narrow for evenly spread samples to be sure to meet it; the other
# profiles are as fine at one place as at any other. It is scanned once, on lines of a net of the
# whole surface: a spot wider than about a thousandth of the surface is met.
FEATURE_NET_LINE_COUNT = 1000
# The net is searched in FEATURE_TILES_PER_SIDE × FEATURE_TILES_PER_SIDE parts, and the most
# remarkable of them are followed up.
FEATURE_TILES_PER_SIDE = 20
REFINED_FEATURE_TILE_COUNT = 16


@lru_cache(maxsize=16)
def narrow_feature_points(profile: Profile) -> tuple[np.ndarray, np.ndarray]:
    """Points x_m, y_m that a sampling of the profile should include; none but for formulas.

    They are where it differs most from its neighbourhood. A spot narrower than a five-hundredth of
    half the surface, with no trace beyond, can be missed.
    """
    if not isinstance(profile, Formula):
        return np.zeros(0), np.zeros(0)
    # Uneven lines, so that nothing with a period hides between them.
    uneven = np.arange(FEATURE_NET_LINE_COUNT) * 0.6180339887498949 % 1
    lines = 2 * (np.arange(FEATURE_NET_LINE_COUNT) + uneven) / FEATURE_NET_LINE_COUNT - 1
    x_lines_m, y_lines_m = (half * lines for half in profile.surface.half_extents_m)
    with np.errstate(all="ignore"):
        s = profile.amplitude(x_m=x_lines_m[:, None], y_m=y_lines_m[None, :])
        bends = np.maximum(
            _distances_from_chords(s, x_lines_m), _distances_from_chords(s.T, y_lines_m).T
        )
    bends[profile.surface.relative_distance(x_lines_m[:, None], y_lines_m[None, :]) > 1] = 0.0
    side = FEATURE_NET_LINE_COUNT // FEATURE_TILES_PER_SIDE
    tiles = (
        bends.reshape(FEATURE_TILES_PER_SIDE, side, FEATURE_TILES_PER_SIDE, side)
        .transpose(0, 2, 1, 3)
        .reshape(FEATURE_TILES_PER_SIDE**2, -1)
    )
    first = np.argsort(-tiles.max(axis=1), kind="stable")[:REFINED_FEATURE_TILE_COUNT]
    row, column = np.divmod(tiles[first].argmax(axis=1), side)
    # Within two lines of each, where the profile stands out most from what is around.
    near = np.meshgrid(*2 * [4 * np.linspace(-1, 1, 65) / FEATURE_NET_LINE_COUNT])
    half_x_m, half_y_m = profile.surface.half_extents_m
    x_m = x_lines_m[first // FEATURE_TILES_PER_SIDE * side + row, None] + half_x_m * near[0].ravel()
    y_m = (
        y_lines_m[first % FEATURE_TILES_PER_SIDE * side + column, None] + half_y_m * near[1].ravel()
    )
    with np.errstate(all="ignore"):
        s = profile.amplitude(x_m=x_m, y_m=y_m)
        contrast = np.nan_to_num(np.abs(s - s.mean(axis=1, keepdims=True)), posinf=0.0)
    best = np.arange(len(x_m)), contrast.argmax(axis=1)
    return x_m[best], y_m[best]


def _distances_from_chords(s: np.ndarray, lines_m: np.ndarray) -> np.ndarray:
    """Return each value's distance from the line through its neighbours along axis 0."""
    fraction = ((lines_m[1:-1] - lines_m[:-2]) / (lines_m[2:] - lines_m[:-2]))[:, None]
    bends = np.zeros(s.shape)
    bends[1:-1] = np.abs(s[1:-1] - (1 - fraction) * s[:-2] - fraction * s[2:])
    return np.nan_to_num(bends, nan=0.0, posinf=0.0)
