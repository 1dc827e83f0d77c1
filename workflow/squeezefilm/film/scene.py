"""One operating point of a squeeze film, and the dimensionless numbers that govern it."""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import cos, hypot, pi, radians, sin, sqrt
from typing import TypeVar

import numpy as np

from squeezefilm.film.contour import DENSE, Contour
from squeezefilm.film.outlines import Outline, ellipse
from squeezefilm.film.vibration.shapes import TwoPhases, Vibration, parts_of, phasor_of
from squeezefilm.film.vibration.surfaces import Surface

OUTLINE_POINTS = 144

Number = TypeVar("Number", float, np.ndarray)


@dataclass(frozen=True)
class Gas:
    """The film's gas.

    ``rarefaction`` is ``none`` (viscous flow), ``slip`` (first order) or ``fukui-kaneko``.
    The density follows the pressure as ρ ~ p^(1/n) with the ``polytropic_exponent`` n: 1 for an
    isothermal film, the ratio of specific heats for an adiabatic one. The mean free path is given
    at ambient density and goes like 1/ρ, as for molecules of a fixed size. ``inertia`` and
    ``heat`` are ``none`` or ``included``; ``auto`` is decided before a scene is solved
    (effects/automatic.py). Heat goes by the Prandtl number, the ratio of specific heats and the
    exponent κ of viscosity ~ temperature^κ. What the equation of a scene leaves out enters its
    budget alone (reynolds/effects).
    """

    viscosity_pa_s: float
    ambient_pressure_pa: float
    density_kg_per_m3: float
    mean_free_path_m: float
    rarefaction: str
    polytropic_exponent: float
    inertia: str
    heat: str
    prandtl: float
    heat_capacity_ratio: float
    viscosity_exponent: float


@dataclass(frozen=True)
class Actuator:
    """A surface that vibrates normal to itself at one frequency, by hv · s(x, y) sin ωt.

    Or, with a profile in two phases, by hv · (s₁ sin ωt + s₂ cos ωt).
    """

    frequency_hz: float
    surface: Surface
    profile: Vibration

    @property
    def angular_frequency_rad_per_s(self) -> float:
        return 2 * pi * self.frequency_hz


@dataclass(frozen=True)
class GapShape:
    """How the gap at rest differs from place to place under the finger; zero at its centre.

    ``tilt_x_m`` is the gap at the middle of the side at +x less that at −x, ``tilt_y_m`` likewise;
    ``bulge_m`` the gap at the middle of a side less that at the centre: positive for a pad that
    bulges towards the surface.
    """

    tilt_x_m: float = 0.0
    tilt_y_m: float = 0.0
    bulge_m: float = 0.0

    @cached_property
    def flat(self) -> bool:
        return not (self.tilt_x_m or self.tilt_y_m or self.bulge_m)

    def rise_m(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Gap at rest less h0 at positions in [0, 1] across the finger."""
        x, y = x - 0.5, y - 0.5
        tilt: np.ndarray = self.tilt_x_m * x + self.tilt_y_m * y
        return tilt + 4 * self.bulge_m * (x**2 + y**2)


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
    gap: GapShape = GapShape()
    contour: Contour | None = None

    @property
    def area_m2(self) -> float:
        if self.contour:
            return self.contour.outline.area * self.length_x_m**2
        share = pi / 4 if self.shape == "ellipse" else 1.0
        return share * self.length_x_m * self.length_y_m

    @property
    def reach_m(self) -> float:
        """Distance of the outline's farthest point from the finger's centre."""
        if self.contour:
            return float(np.abs(self.contour.rim).max()) * self.length_x_m
        if self.shape == "ellipse":
            return max(self.length_x_m, self.length_y_m) / 2
        return hypot(self.length_x_m, self.length_y_m) / 2

    @property
    def rectangle_within(self) -> float:
        """Sides of the largest rectangle of its proportions about its centre, over its own."""
        if self.contour:
            rim = self.contour.rim
            across = np.maximum(2 * np.abs(rim.real), 2 * np.abs(rim.imag) / self.contour.aspect)
            return float(across.min())
        return sqrt(0.5) if self.shape == "ellipse" else 1.0

    @property
    def smooth_outline(self) -> Outline | None:
        """The outline in conformal coordinates, unless it is a rectangle."""
        if self.contour:
            return self.contour.outline
        return ellipse(self.length_y_m / self.length_x_m) if self.shape == "ellipse" else None

    def outline(self) -> list[tuple[float, float]]:
        """Points on the rim from the finger's centre, along the actuator's axes: (x_m, y_m).

        A rectangle's four corners, or points all around another pad.
        """
        half_x, half_y = self.length_x_m / 2, self.length_y_m / 2
        if self.contour:
            rim = self.contour.rim[:: DENSE // (2 * OUTLINE_POINTS)] * self.length_x_m
            points = list(zip(rim.real.tolist(), rim.imag.tolist(), strict=True))
        elif self.shape == "ellipse":
            angles = (2 * pi * step / OUTLINE_POINTS for step in range(OUTLINE_POINTS))
            points = [(half_x * cos(angle), half_y * sin(angle)) for angle in angles]
        else:
            points = [(-half_x, -half_y), (half_x, -half_y), (half_x, half_y), (-half_x, half_y)]
        return [self.turned(x, y) for x, y in points]

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


@dataclass(frozen=True)
class Scene:
    """One operating point: gap, amplitude and finger position on a given actuator.

    ``h0_m`` is the mean gap, ``hv_m`` the amplitude at the profile's maximum; the finger's centre
    lies at (``x_m``, ``y_m``) from the surface's and the pad keeps its orientation.
    """

    point_id: str
    h0_m: float
    hv_m: float
    x_m: float
    y_m: float
    gas: Gas
    actuator: Actuator
    finger: Finger

    @cached_property
    def epsilon(self) -> float:
        """Excursion ratio hv/h0."""
        return self.hv_m / self.h0_m

    @cached_property
    def sigma(self) -> float:
        """Squeeze number 12 μ ω l0² / (p0 h0²), l0 the finger's length along x (paper eq. 1)."""
        return (
            12
            * self.gas.viscosity_pa_s
            * self.actuator.angular_frequency_rad_per_s
            * self.finger.length_x_m**2
            / (self.gas.ambient_pressure_pa * self.h0_m**2)
        )

    @cached_property
    def bearing_number(self) -> float:
        """Bearing number Λ = 6 μ U l0 / (p0 h0²) (paper eq. 1)."""
        return (
            6
            * self.gas.viscosity_pa_s
            * self.finger.speed_x_m_per_s
            * self.finger.length_x_m
            / (self.gas.ambient_pressure_pa * self.h0_m**2)
        )

    @property
    def knudsen(self) -> float:
        """Knudsen number: mean free path over mean gap, at ambient density."""
        return self.gas.mean_free_path_m / self.h0_m

    @property
    def inverse_knudsen(self) -> float:
        """D = √π / (2 Kn) at the mean gap and ambient density (Fukui and Kaneko)."""
        return sqrt(pi) / (2 * self.knudsen)

    @property
    def modified_reynolds(self) -> float:
        """Modified Reynolds number ρ ω h0² / μ: the inertia that eq. (1) leaves out."""
        return (
            self.gas.density_kg_per_m3
            * self.actuator.angular_frequency_rad_per_s
            * self.h0_m**2
            / self.gas.viscosity_pa_s
        )

    @property
    def aspect(self) -> float:
        """Length of the finger along y over its length along x."""
        return self.finger.length_y_m / self.finger.length_x_m

    @property
    def force_scale_n(self) -> float:
        """p0 times the finger's area: the force of a mean overpressure of one atmosphere."""
        return self.gas.ambient_pressure_pa * self.finger.area_m2

    @cached_property
    def place(self) -> tuple[Vibration, Finger, float, float]:
        """All that the profile under the finger depends on: equal for scenes that share it."""
        return self.actuator.profile, self.finger, self.x_m, self.y_m

    @cached_property
    def place_hash(self) -> int:
        """Its hash, which takes as long as many a step of preparing a scene."""
        return hash(self.place)

    @property
    def two_phases(self) -> bool:
        """Whether the surface does not move in one phase: a travelling wave, modes with a lag."""
        return isinstance(self.actuator.profile, TwoPhases)

    @property
    def plain(self) -> bool:
        """Whether the gap is even at rest and moves in one phase."""
        return self.finger.gap.flat and not self.two_phases

    def parts(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The profile's s, or s₁ and s₂, at positions x, y in [0, 1] across the finger.

        Shape (phases, …), x and y of any common shape.
        """
        return parts_of(self.actuator.profile, **self._place_of(x, y))

    def phasor(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """s, or s₁ + i s₂, at positions in [0, 1] across the finger."""
        return phasor_of(self.actuator.profile, **self._place_of(x, y))

    def _place_of(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Positions across the finger on the actuator."""
        along_x, along_y = self.finger.turned(
            (x - 0.5) * self.finger.length_x_m, (y - 0.5) * self.finger.length_y_m
        )
        return {"x_m": self.x_m + along_x, "y_m": self.y_m + along_y}

    def amplitude(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Profile s of a vibration in one phase at positions in [0, 1] across the finger."""
        (s,) = self.parts(x, y)
        return s

    def magnitude(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """How far the surface moves over a period, |s| or √(s₁² + s₂²)."""
        return np.abs(self.phasor(x, y))

    def rest_gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Gap over h0 without vibration at positions in [0, 1] across the finger."""
        return 1 + self.finger.gap.rise_m(x, y) / self.h0_m

    def gap(self, x: np.ndarray, y: np.ndarray, phase: np.ndarray) -> np.ndarray:
        """Gap over h0 at positions in [0, 1], any common shape, at phases ωt, one more dimension.

        It widens while sin ωt > 0: the surface goes down.
        """
        moves = zip(self.parts(x, y), (np.sin(phase), np.cos(phase)), strict=False)
        moved = sum(part[..., None] * each for part, each in moves)
        return self.rest_gap(x, y)[..., None] + self.epsilon * moved

    @cached_property
    def narrowest(self) -> float:
        """Least gap over h0 in a period; of a flat gap as if the profile's maximum lay under it."""
        if self.finger.gap.flat:
            return 1 - self.epsilon
        return float((self.rest_inside - self.epsilon * _moves_inside(AtPlace(self))).min())

    def closure(self) -> float:
        """Largest excursion over gap at rest, 1 where surface and finger touch.

        For a flat gap as if the profile's maximum lay under the finger: ε, or a little more where
        noise has put something on the maximum of a measured profile.
        """
        if self.finger.gap.flat:
            return self.epsilon * getattr(self.actuator.profile, "largest", 1.0)
        gap, excursion = self.rest_inside, self.epsilon * _moves_inside(AtPlace(self))
        return float(np.max(np.where(gap > 0, excursion / gap, 1.0)))

    def inside(self) -> tuple[np.ndarray, np.ndarray]:
        """A net of points x, y over the finger, rim included, in [0, 1]."""
        return _net(self.finger)

    @property
    def rest_inside(self) -> np.ndarray:
        """Gap over h0 without vibration on that net."""
        return 1 + _rises_inside(self.finger) / self.h0_m


class AtPlace:
    """A scene as far as the profile under the finger goes: scenes at one place are equal."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    def __hash__(self) -> int:
        return self.scene.place_hash

    def __eq__(self, other: object) -> bool:
        return isinstance(other, AtPlace) and (
            self.scene is other.scene or self.scene.place == other.scene.place
        )


# A study has many gaps and amplitudes at few places.


@lru_cache(maxsize=256)
def _net(finger: Finger) -> tuple[np.ndarray, np.ndarray]:
    if finger.contour:
        across, nu = np.meshgrid(np.linspace(0.5, 1, 11), np.linspace(0, 2 * pi, 97))
        return finger.contour.outline.positions(across, nu)
    if finger.shape == "ellipse":
        r, angle = np.meshgrid(np.linspace(0, 0.5, 11), np.linspace(0, 2 * pi, 49))
        return 0.5 + r * np.cos(angle), 0.5 + r * np.sin(angle)
    side = np.linspace(0, 1, 25)
    x, y = np.meshgrid(side, side, indexing="ij")
    return x, y


@lru_cache(maxsize=256)
def _rises_inside(finger: Finger) -> np.ndarray:
    """Gap at rest less h0 on the net over a finger."""
    return finger.gap.rise_m(*_net(finger))


@lru_cache(maxsize=1024)
def _moves_inside(at: AtPlace) -> np.ndarray:
    """How far the surface moves over a period on the net, in units of hv."""
    return at.scene.magnitude(*at.scene.inside())
