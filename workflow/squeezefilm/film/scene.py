"""One operating point of a squeeze film, and the dimensionless numbers that govern it."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from squeezefilm.film.finger import Finger, net
from squeezefilm.film.profiles import Profile
from squeezefilm.film.surfaces import Surface


@dataclass(frozen=True)
class Gas:
    """The film's gas.

    ``rarefaction`` is ``none`` (viscous flow), ``slip`` (first order) or ``fukui-kaneko``.
    The density follows the pressure as ρ ~ p^(1/n) with the ``polytropic_exponent`` n: 1 for an
    isothermal film, the ratio of specific heats for an adiabatic one. The mean free path is given
    at ambient density and goes like 1/ρ, as for molecules of a fixed size; slip of first order is
    by a length of ``slip_coefficient`` times it. ``inertia`` and ``heat`` are ``none`` or
    ``included``; ``auto`` is decided before a scene is solved (quantities/model_error.py). Heat
    goes by the Prandtl number, the ratio of specific heats and the exponent κ of viscosity ~
    temperature^κ. What the equation of a scene leaves out enters its budget alone
    (quantities/model_error.py).
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
    slip_coefficient: float = 1.0


@dataclass(frozen=True)
class Actuator:
    """A surface that vibrates normal to itself at one frequency, by hv · Im(s(x, y) e^(iωt))."""

    frequency_hz: float
    surface: Surface
    profile: Profile

    @property
    def angular_frequency_rad_per_s(self) -> float:
        return 2 * pi * self.frequency_hz


class _OnNet(NamedTuple):
    """What is asked of a shaped gap, on a net of points under the finger, over h0."""

    narrowest: float
    closure: float


class _Inside(NamedTuple):
    """The gap at a place on the net: what it is at rest less h0, and how far the surface moves over
    a period, in units of hv, where no other point has less of the first and as much of the second;
    and the first's least, largest, mean and mean square about that, on all of the net.
    """

    rises_m: np.ndarray
    moves: np.ndarray
    least_m: float
    largest_m: float
    mean_m: float
    variance_m2: float


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
    def slip_knudsen(self) -> float:
        """Length of first-order slip over mean gap, at ambient density; 0 without such slip."""
        return self.gas.slip_coefficient * self.knudsen * (self.gas.rarefaction == "slip")

    @property
    def inverse_knudsen(self) -> float:
        """D = √π / (2 Kn) at the mean gap and ambient density (Fukui and Kaneko)."""
        return sqrt(pi) / (2 * self.knudsen)

    @cached_property
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
    def place(self) -> tuple[Profile, Finger, float, float]:
        """All that the profile under the finger depends on: equal for scenes that share it."""
        return self.actuator.profile, self.finger, self.x_m, self.y_m

    @cached_property
    def place_hash(self) -> int:
        """Its hash, which takes as long as many a step of preparing a scene."""
        return hash(self.place)

    @cached_property
    def at(self) -> "AtPlace":
        """The same for all scenes at one place, so that they need not be compared again."""
        return _at(AtPlace(self))

    @property
    def plain(self) -> bool:
        """Whether the gap is even at rest and moves in one phase."""
        return self.finger.gap.flat and not self.actuator.profile.is_complex

    def amplitude(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The profile's s at positions x, y in [0, 1] across the finger, any common shape."""
        along_x, along_y = self.finger.turned(
            (x - 0.5) * self.finger.length_x_m, (y - 0.5) * self.finger.length_y_m
        )
        return self.actuator.profile.amplitude(x_m=self.x_m + along_x, y_m=self.y_m + along_y)

    def parts(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Real and, of a complex one, imaginary part of ``amplitude``, shape (1 or 2, …)."""
        s = self.amplitude(x, y)
        return np.stack([s.real, s.imag]) if np.iscomplexobj(s) else s[None]

    def rest_gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Gap over h0 without vibration at positions in [0, 1] across the finger."""
        return 1 + self.finger.gap.rise_m(x, y) / self.h0_m

    def gap(self, x: np.ndarray, y: np.ndarray, phase: np.ndarray) -> np.ndarray:
        """Gap over h0 at positions in [0, 1], any common shape, at phases ωt, one more dimension.

        It widens while sin ωt > 0: the surface goes down.
        """
        moved = (self.amplitude(x, y)[..., None] * np.exp(1j * phase)).imag
        return self.rest_gap(x, y)[..., None] + self.epsilon * moved

    @property
    def narrowest(self) -> float:
        """Least gap over h0 in a period; of a flat gap as if the profile's maximum lay under it."""
        return 1 - self.epsilon if self.finger.gap.flat else self._on_net.narrowest

    def closure(self) -> float:
        """Largest excursion over gap at rest, 1 where surface and finger touch.

        For a flat gap as if the profile's maximum lay under the finger: ε, or a little more where
        noise has put something on the maximum of a measured profile.
        """
        if self.finger.gap.flat:
            return self.epsilon * getattr(self.actuator.profile, "largest", 1.0)
        return self._on_net.closure

    @cached_property
    def rest_range(self) -> tuple[float, float]:
        """Least and largest gap over h0 without vibration."""
        if self.finger.gap.flat:
            return 1.0, 1.0
        known = _inside(self.at)
        return 1 + known.least_m / self.h0_m, 1 + known.largest_m / self.h0_m

    @property
    def typical_rest(self) -> float:
        """A mean of the gap G over h0 without vibration that goes by where it is narrow.

        (mean of 1/G⁴)^(-1/4), to second order in what G is more than its mean.
        """
        if self.finger.gap.flat:
            return 1.0
        known = _inside(self.at)
        mean, variance = 1 + known.mean_m / self.h0_m, known.variance_m2 / self.h0_m**2
        return mean**2 / sqrt(mean**2 + 5 * variance)

    @cached_property
    def _on_net(self) -> _OnNet:
        known = _inside(self.at)
        rest, excursion = 1 + known.rises_m / self.h0_m, self.epsilon * known.moves
        touching = known.least_m <= -self.h0_m
        return _OnNet(
            narrowest=float((rest - excursion).min()),
            closure=1.0 if touching else float((excursion / rest).max()),
        )

    def inside(self) -> tuple[np.ndarray, np.ndarray]:
        """A net of points x, y over the finger, rim included, in [0, 1]."""
        return net(self.finger)


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


@lru_cache(maxsize=4096)
def _at(place: AtPlace) -> AtPlace:
    return place


@lru_cache(maxsize=1024)
def _inside(at: AtPlace) -> _Inside:
    x, y = (each.ravel() for each in at.scene.inside())
    rises_m = at.scene.finger.gap.rise_m(x, y)
    of_rises = (rises_m.min(), rises_m.max(), rises_m.mean(), rises_m.var())
    moves = np.abs(at.scene.amplitude(x, y))
    order = np.lexsort((-moves, rises_m))
    rises_m, moves = rises_m[order], moves[order]
    # What is no number stays, for it has no finite value to be hidden behind.
    most_before = np.maximum.accumulate(np.append(-np.inf, moves[:-1]))
    hardest = ~(moves <= most_before)
    return _Inside(rises_m[hardest], moves[hardest], *map(float, of_rises))
