"""One operating point of a squeeze film, and the dimensionless numbers that govern it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from math import pi, sqrt
from operator import attrgetter
from typing import Annotated, Any, TypeVar, overload

import numpy as np
from pydantic import Field, GetPydanticSchema

from squeezefilm.film.gas import Gas as Gas
from squeezefilm.film.pad import Pad, net_points_on_pad
from squeezefilm.film.profiles import Profile, ProfileOfStudy, ScanFile
from squeezefilm.film.surfaces import Disc, Rectangle, Surface
from squeezefilm.sections import NOT_GIVEN, SECTION_CONFIG, BoundedNumber, Length, error_at_key

PROFILE_SCHEMA = GetPydanticSchema(
    lambda _, schema: schema(Annotated[ProfileOfStudy, Field(discriminator="kind")])
)
"""Profiles that a study can have are told apart by their ``kind``."""


@dataclass(frozen=True)
class Actuator:
    """The vibrating surface, a disc or a rectangle.

    It moves normal to itself, by hv · Im(s(x, y) e^(iωt)).

    Attributes:
        frequency_hz: frequency of the vibration
        surface_radius_m: of a disc: its radius; the pad must lie on it with all its corners
        profile: shape of the vibration, with maximum 1 on the surface. Its `kind` decides the other
            keys: `sinc`, sin(πkr)/(πkr) (paper eq. 2); `piston`, it moves as a whole;
            `standing-wave`, ~ cos(2πu/λ); `travelling-wave`, cos(ωt − 2πu/λ); `bessel`, a bending
            mode [J_n(kr) + c I_n(kr)] cos n(φ − φ0); `formula`; `measured`
    """

    __pydantic_config__ = SECTION_CONFIG

    frequency_hz: Annotated[float, BoundedNumber("Hz", 1e-3, 1e9)]
    surface_radius_m: Length = NOT_GIVEN
    rectangle: Annotated[Rectangle, Field(alias="surface")] = field(default=NOT_GIVEN, kw_only=True)
    profile: Annotated[Profile, PROFILE_SCHEMA] = field(kw_only=True)

    @property
    def surface(self) -> Surface:
        """The surface, from whose centre positions count."""
        return self.rectangle or Disc(self.surface_radius_m)

    @property
    def angular_frequency_rad_per_s(self) -> float:
        return 2 * pi * self.frequency_hz


def validate_surface_keys(actuator: Actuator) -> Actuator:
    """An actuator that has one surface, and a profile that this can have."""
    if (actuator.rectangle is None) == (actuator.surface_radius_m is None):
        raise error_at_key(
            "give surface_radius, of a disc, or surface, of a rectangle, and not both"
        )
    profile = actuator.profile
    if isinstance(profile, ScanFile) and actuator.rectangle and profile.axisymmetric:
        raise error_at_key("a rectangle has no axis; it must be false", "profile", "axisymmetric")
    if isinstance(profile, ScanFile) and not actuator.rectangle and profile.along:
        raise error_at_key("is of a rectangle; a disc has axisymmetric", "profile", "along")
    return actuator


class OperatingPoints:
    """The dimensionless numbers of operating points: of one scene, or of many as arrays (n,)."""

    h0_m: Any
    hv_m: Any
    gas: Gas
    actuator: Actuator
    pad: Pad

    @cached_property
    def epsilon(self) -> Any:
        """Excursion ratio hv/h0."""
        return self.hv_m / self.h0_m

    @cached_property
    def sigma(self) -> Any:
        """Squeeze number 12 μ ω l0² / (p0 h0²), l0 the pad's length along x (paper eq. 1)."""
        speed = self.actuator.angular_frequency_rad_per_s * self.pad.length_x_m**2
        return 12 * self.gas.viscosity_pa_s * speed / self._pressure_times_gap_squared

    @cached_property
    def bearing_number(self) -> Any:
        """Bearing number Λ = 6 μ U l0 / (p0 h0²) (paper eq. 1)."""
        speed = self.pad.speed_x_m_per_s * self.pad.length_x_m
        return 6 * self.gas.viscosity_pa_s * speed / self._pressure_times_gap_squared

    @property
    def _pressure_times_gap_squared(self) -> Any:
        return self.gas.ambient_pressure_pa * self.h0_m**2

    @property
    def knudsen(self) -> Any:
        """Knudsen number: mean free path over mean gap, at ambient density."""
        return self.gas.mean_free_path_m / self.h0_m

    @property
    def slip_knudsen(self) -> Any:
        """Length of first-order slip over mean gap, at ambient density; 0 without such slip."""
        return self.gas.slip_coefficient * self.knudsen * (self.gas.rarefaction == "slip")

    @property
    def inverse_knudsen(self) -> Any:
        """Inverse Knudsen number D = √π / (2 Kn) at the mean gap and ambient density."""
        return sqrt(pi) / (2 * self.knudsen)

    @cached_property
    def modified_reynolds(self) -> Any:
        """Modified Reynolds number ρ ω h0² / μ: the inertia that eq. (1) neglects."""
        omega = self.actuator.angular_frequency_rad_per_s
        return self.gas.density_kg_per_m3 * omega * self.h0_m**2 / self.gas.viscosity_pa_s

    @property
    def shear_reynolds(self) -> Any:
        """Shear Reynolds number ρ |U| h0² / (μ l0): inertia of gas that a sliding pad shears."""
        gas, speed = self.gas, np.abs(self.pad.speed_x_m_per_s)
        per_length = gas.density_kg_per_m3 * speed / gas.viscosity_pa_s / self.pad.length_x_m
        return per_length * self.h0_m**2

    @property
    def aspect(self) -> Any:
        """Length of the pad along y over its length along x."""
        return self.pad.length_y_m / self.pad.length_x_m


@dataclass(frozen=True)
class Scene(OperatingPoints):
    """One operating point: gap, amplitude and pad position on a given actuator.

    ``h0_m`` is the mean gap, ``hv_m`` the amplitude at the profile's maximum; the pad's centre
    lies at (``x_m``, ``y_m``) from the surface's and the pad keeps its orientation.
    """

    point_id: str
    h0_m: float
    hv_m: float
    x_m: float
    y_m: float
    gas: Gas
    actuator: Actuator
    pad: Pad

    @property
    def force_scale_n(self) -> float:
        """The force in newtons of a mean gauge pressure p0 on the pad."""
        return self.gas.ambient_pressure_pa * self.pad.area_m2

    @property
    def film(self) -> Film:
        """The film, which is the same at all operating points."""
        return Film(self.gas, self.actuator, self.pad)

    def with_gas(self, **numbers: Any) -> Scene:
        """The scene with other numbers or terms of its gas."""
        return replace(self, gas=replace(self.gas, **numbers))

    def viscous(self) -> Scene:
        """The scene of a gas without inertia and thermal effects."""
        is_viscous = self.gas.inertia == self.gas.thermal == "none"
        return self if is_viscous else self.with_gas(inertia="none", thermal="none")

    def amplitude(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The profile's s at positions x, y in [0, 1] across the pad, any common shape."""
        return self.film.pad_profile.amplitude(x, y, x_m=self.x_m, y_m=self.y_m)

    def gap(self, x: np.ndarray, y: np.ndarray, phase: np.ndarray) -> np.ndarray:
        """Gap over h0 at positions in [0, 1], any common shape, at phases ωt, one more dimension.

        It widens while sin ωt > 0: the surface goes down.
        """
        moved = (self.amplitude(x, y)[..., None] * np.exp(1j * phase)).imag
        rest = 1 + self.pad.gap.rise_m(x, y) / self.h0_m
        return rest[..., None] + self.epsilon * moved

    def closure(self) -> float:
        """Largest excursion over gap at rest, 1 where surface and pad touch (``Scenes``)."""
        return float(self._as_scenes.closure[0])

    def inside(self) -> tuple[np.ndarray, np.ndarray]:
        """A net of points x, y over the pad, edge included, in [0, 1]."""
        return net_points_on_pad(self.pad)

    @property
    def pad_positions(self) -> PadPositions:
        """The pad's position."""
        return self._as_scenes.pad_positions[0]

    @cached_property
    def _as_scenes(self) -> Scenes:
        return Scenes.of([self])


class HashedOnce:
    """A frozen dataclass that caches its hash, since it serves as key of many caches."""

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash(tuple([getattr(self, attribute.name) for attribute in fields(self)]))  # type: ignore[arg-type]


@dataclass(frozen=True)
class PadProfile(HashedOnce):
    """A vibration profile and a pad; with a pad position it gives the profile under the pad."""

    profile: Profile
    pad: Pad
    __hash__ = HashedOnce.__hash__

    def amplitude(
        self, x: np.ndarray, y: np.ndarray, *, x_m: float | np.ndarray, y_m: float | np.ndarray
    ) -> np.ndarray:
        """The profile's s at points x, y in [0, 1] across the pad, whose centre is at x_m, y_m."""
        along_x, along_y = self.pad.to_actuator_axes(
            (x - 0.5) * self.pad.length_x_m, (y - 0.5) * self.pad.length_y_m
        )
        return self.profile.amplitude(x_m=x_m + along_x, y_m=y_m + along_y)


@dataclass(frozen=True)
class Film(HashedOnce):
    """Gas, actuator and pad: the part of a scene that all operating points share."""

    gas: Gas
    actuator: Actuator
    pad: Pad
    __hash__ = HashedOnce.__hash__

    @cached_property
    def pad_profile(self) -> PadProfile:
        return PadProfile(self.actuator.profile, self.pad)

    def with_gas(self, **numbers: Any) -> Film:
        """The film with other numbers or terms of its gas."""
        return replace(self, gas=replace(self.gas, **numbers))

    def scene(
        self, h0_m: float, hv_m: float, x_m: float = 0.0, y_m: float = 0.0, *, point_id: str = "1"
    ) -> Scene:
        """An operating point of the film, which may not exist (film/validity.py)."""
        return Scene(point_id, h0_m, hv_m, x_m, y_m, self.gas, self.actuator, self.pad)

    def scenes(
        self, h0_m: np.ndarray, hv_m: np.ndarray, x_m: np.ndarray, y_m: np.ndarray
    ) -> Scenes:
        """Operating points of the film, numbered from 1, which may not exist."""
        point_id = np.array([str(row + 1) for row in range(len(h0_m))], dtype=object)
        index = np.zeros(len(h0_m), dtype=np.int64)
        return Scenes((self,), index, h0_m, hv_m, x_m, y_m, point_id)


GAS_ATTRIBUTES = tuple(each.name for each in fields(Gas))
# Which of some scenes.
Rows = slice | np.ndarray
# Positions up to which what is known of them is kept.
MAX_CACHED_POSITIONS = 256
Result = TypeVar("Result")


def distinct_row_indices(*columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first of the rows that differ, and which of these each row is, (n,)."""
    count = len(columns[0])
    which = np.zeros(count, dtype=np.int64)
    if count == 1 or all([(column == column[:1]).all() for column in columns]):
        return which[:1], which
    order = np.lexsort(columns[::-1])
    is_new = np.arange(count) == 0
    for column in columns:
        in_order = column[order]
        is_new[1:] |= in_order[1:] != in_order[:-1]
    which[order] = np.cumsum(is_new) - 1
    return order[is_new], which


def equal_row_groups(*columns: np.ndarray) -> list[np.ndarray]:
    """The numbers of equal rows, each group of them in an array."""
    first, which = distinct_row_indices(*columns)
    if len(first) < 2:
        return [np.arange(len(which))][: len(which)]
    ends = np.cumsum(np.bincount(which))[:-1]
    return np.split(np.argsort(which, kind="stable"), ends)


@dataclass(frozen=True, eq=False)
class PadPositions:
    """The pad's positions among scenes of one film, each once: x_m, y_m, shape (positions,).

    Those of the same positions are equal, so that what is known of them can be kept.
    """

    pad_profile: PadProfile
    x_m: np.ndarray
    y_m: np.ndarray

    @cached_property
    def _key(self) -> tuple[PadProfile, bytes, bytes]:
        return self.pad_profile, self.x_m.tobytes(), self.y_m.tobytes()

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PadPositions) and self._key == other._key

    def component_amplitudes(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The profile's real and, of a complex one, imaginary part at points across the pad.

        Shape (parts, positions, points).
        """
        s = self.amplitude(x, y)
        return np.stack([s.real, s.imag]) if np.iscomplexobj(s) else s[None]

    def amplitude(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The profile's s at points across the pad, shape (positions, points)."""
        return self.pad_profile.amplitude(x, y, x_m=self.x_m[:, None], y_m=self.y_m[:, None])

    def subset(self, rows: Rows) -> PadPositions:
        return PadPositions(self.pad_profile, self.x_m[rows], self.y_m[rows])

    def compute_cached(self, find: Callable[..., Result], *arguments: Any) -> Result:
        """Return what a function finds of the positions, kept for when it is asked for again.

        Many gaps and amplitudes share their positions; of more than a few it is found each time.
        """
        call = call_cached if len(self.x_m) <= MAX_CACHED_POSITIONS else call_cached.__wrapped__
        return call(find, self, *arguments)


@lru_cache(maxsize=512)
def call_cached(find: Callable[..., Any], *arguments: Any) -> Any:
    """Return what a function finds of films and positions, known already where it was asked for."""
    return find(*arguments)


@dataclass(frozen=True, eq=False)
class Scenes(OperatingPoints, Sequence[Scene]):
    """Many operating points as columns, each of shape (n,); ``scenes[k]`` is one of them.

    Attributes:
        films: those that there are; ``film_index`` is each scene's.
        h0_m, hv_m, x_m, y_m, point_id: as of a ``Scene``.
    """

    films: tuple[Film, ...]
    film_index: np.ndarray
    h0_m: np.ndarray
    hv_m: np.ndarray
    x_m: np.ndarray
    y_m: np.ndarray
    point_id: np.ndarray

    @classmethod
    def of(cls, scenes: Sequence[Scene] | Scenes) -> Scenes:
        """The columns of some scenes."""
        if isinstance(scenes, Scenes):
            return scenes
        films: dict[Film, int] = {}
        known: dict[tuple[int, ...], int] = {}  # by parts that are the same: hashing takes longer
        index, scenes = [], list(scenes)
        for scene in scenes:
            parts = id(scene.gas), id(scene.actuator), id(scene.pad)
            if parts not in known:
                known[parts] = films.setdefault(scene.film, len(films))
            index.append(known[parts])
        columns = np.array([(scene.h0_m, scene.hv_m, scene.x_m, scene.y_m) for scene in scenes])
        point_id = np.array([scene.point_id for scene in scenes], dtype=object)
        h0_m, hv_m, x_m, y_m = columns.reshape(-1, 4).T.copy()
        return cls(tuple(films), np.array(index), h0_m, hv_m, x_m, y_m, point_id)

    def __len__(self) -> int:
        return len(self.h0_m)

    @overload
    def __getitem__(self, rows: int) -> Scene: ...
    @overload
    def __getitem__(self, rows: Rows) -> Scenes: ...
    def __getitem__(self, rows: int | Rows) -> Scene | Scenes:
        index, point_id = self.film_index[rows], self.point_id[rows]
        numbers = [each[rows] for each in (self.h0_m, self.hv_m, self.x_m, self.y_m)]
        if isinstance(rows, (int, np.integer)):
            return self.films[index].scene(*map(float, numbers), point_id=str(point_id))
        films = self.films
        # A column of films' values takes time for each of them.
        if len(films) > len(index) > 0:
            known = {film: place for place, film in enumerate(dict.fromkeys(index.tolist()))}
            films = tuple(films[film] for film in known)
            index = np.array([known[film] for film in index.tolist()], dtype=np.int64)
        return Scenes(films, index, *numbers, point_id)  # type: ignore[call-arg]

    def film_value_column(self, of_film: Callable[[Film], Any]) -> Any:
        """Return a value of the scenes' films: one for a single film, else shape (n, …)."""
        if len(self.films) == 1:
            return of_film(self.films[0])
        return np.array([of_film(film) for film in self.films])[self.film_index]

    def split_by_film(self) -> Iterator[tuple[Film, Rows, Scenes]]:
        """Split the scenes by film: the film, the rows of its scenes, and these scenes."""
        if len(self.films) == 1:
            yield self.films[0], slice(None), self
            return
        for rows in equal_row_groups(self.film_index):
            film, scenes_of_film = self.films[self.film_index[rows[0]]], self[rows]
            yield film, rows, replace(scenes_of_film, films=(film,), film_index=np.zeros_like(rows))

    def evaluate_at_positions(
        self, find: Callable[[PadPositions], Result]
    ) -> tuple[list[Result], np.ndarray]:
        """Something at the pad's positions, film by film, and which of all these each scene has."""
        results, count = [], 0
        which = np.empty(len(self), dtype=np.int64)
        for _, rows, scenes_of_film in self.split_by_film():
            positions, at = scenes_of_film.pad_positions
            which[rows] = count + at
            count += len(positions.x_m)
            results.append(find(positions))
        return results, which

    @cached_property
    def is_flat(self) -> bool:
        """Return whether every static gap is uniform."""
        return all([film.pad.gap.flat for film in self.films])

    @cached_property
    def gas(self) -> Gas:  # type: ignore[override]
        """The gas' numbers, those of several films as columns."""
        return self._stacked_film_attributes("gas", *GAS_ATTRIBUTES)

    @cached_property
    def actuator(self) -> Actuator:  # type: ignore[override]
        """The actuator, of several films with a column of frequencies."""
        return self._stacked_film_attributes("actuator", "frequency_hz")

    @cached_property
    def pad(self) -> Pad:  # type: ignore[override]
        """The pad, of several films with columns of its sides and speed."""
        return self._stacked_film_attributes("pad", "length_x_m", "length_y_m", "speed_x_m_per_s")

    def _stacked_film_attributes(self, part: str, *names: str) -> Any:
        first = getattr(self.films[0], part)
        if len(self.films) == 1:
            return first
        return replace(
            first, **{n: self.film_value_column(attrgetter(f"{part}.{n}")) for n in names}
        )

    @cached_property
    def force_scale_n(self) -> Any:
        """The force in newtons of a mean gauge pressure p0 on the pad."""
        return self.gas.ambient_pressure_pa * self.film_value_column(lambda film: film.pad.area_m2)

    @cached_property
    def pad_positions(self) -> tuple[PadPositions, np.ndarray]:
        """The pad's positions of scenes of one film, and which of them each scene has, (n,)."""
        (film,) = self.films
        first, which = distinct_row_indices(self.x_m, self.y_m)
        return PadPositions(film.pad_profile, self.x_m[first], self.y_m[first]), which

    @cached_property
    def narrowest_gap_ratio(self) -> np.ndarray:
        """Least gap over h0 in a period; of a flat gap as if the profile's maximum lay under it."""
        return self._least_gap_ratio_and_closure[0]

    @cached_property
    def closure(self) -> np.ndarray:
        """Largest excursion over gap at rest, 1 where surface and pad touch.

        For a flat gap as if the profile's maximum lay under the pad: ε, or a little more where
        noise has put something on the maximum of a measured profile.
        """
        return self._least_gap_ratio_and_closure[1]

    @cached_property
    def static_gap_ratio_range(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest gap over h0 without vibration."""
        least_m, most_m, _, _ = self._rise_statistics
        return 1 + least_m / self.h0_m, 1 + most_m / self.h0_m

    @property
    def static_gap_ratio_mean(self) -> np.ndarray:
        """Mean static gap over h0, (mean of 1/G⁴)^(−1/4) with the static gap G over h0.

        It weights the narrow places and is exact to second order in the deviation from the mean of
        G.
        """
        _, _, mean_m, variance_m2 = self._rise_statistics
        mean, variance = 1 + mean_m / self.h0_m, variance_m2 / self.h0_m**2
        return np.asarray(mean**2 / np.sqrt(mean**2 + 5 * variance))

    @cached_property
    def _rise_statistics(self) -> np.ndarray:
        return np.array(self.film_value_column(lambda film: _static_rise_statistics(film.pad))).T

    @cached_property
    def _least_gap_ratio_and_closure(self) -> tuple[np.ndarray, np.ndarray]:
        largest = self.film_value_column(
            lambda film: getattr(film.actuator.profile, "largest_magnitude", 1.0)
        )
        narrowest, closure = 1 - self.epsilon, largest * self.epsilon
        for film, rows, scenes_of_film in () if self.is_flat else self.split_by_film():
            if not film.pad.gap.flat:
                narrowest[rows], closure[rows] = scenes_of_film._gap_and_closure_on_net()
        return narrowest, closure

    def _gap_and_closure_on_net(self) -> tuple[np.ndarray, np.ndarray]:
        """``narrowest_gap_ratio`` and ``closure`` of a film whose gap is shaped at rest."""
        pad_positions, which = self.pad_positions
        moves = pad_positions.compute_cached(_amplitude_on_net)
        rises_m = _rise_on_net_m(pad_positions.pad_profile.pad)
        parts = []
        for batch in np.array_split(np.arange(len(self)), 1 + len(self) // SCENES_PER_NET_BATCH):
            rest = 1 + rises_m / self.h0_m[batch, None]
            excursion = self.epsilon[batch, None] * moves[which[batch]]
            with np.errstate(all="ignore"):
                closed = np.where((rest <= 0).any(axis=1), 1.0, (excursion / rest).max(axis=1))
            parts.append(((rest - excursion).min(axis=1), closed))
        narrowest, closure = map(np.concatenate, zip(*parts, strict=True))
        return narrowest, closure


# Scenes that are looked at together on a net of points.
SCENES_PER_NET_BATCH = 128


def _rise_on_net_m(pad: Pad) -> np.ndarray:
    """Gap at rest less h0 on a net of points over the pad."""
    x, y = net_points_on_pad(pad)
    return pad.gap.rise_m(x.ravel(), y.ravel())


@lru_cache(maxsize=256)
def _static_rise_statistics(pad: Pad) -> tuple[float, float, float, float]:
    """Minimum, maximum, mean and variance of static gap minus h0 on a net over the pad."""
    rises_m = _rise_on_net_m(pad)
    return tuple(float(f(rises_m)) for f in (np.min, np.max, np.mean, np.var))  # type: ignore[return-value]


def _amplitude_on_net(pad_positions: PadPositions) -> np.ndarray:
    """Return the surface's amplitude on a net over the pad, over hv: (positions, points)."""
    x, y = (coordinate.ravel() for coordinate in net_points_on_pad(pad_positions.pad_profile.pad))
    return np.abs(pad_positions.amplitude(x, y))
