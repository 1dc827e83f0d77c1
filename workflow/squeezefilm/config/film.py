"""A film in a study's configuration: gas, actuator, pad, and how they are solved."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, PrivateAttr

from squeezefilm.film.gas import GasOfStudy
from squeezefilm.film.outline import read_contour
from squeezefilm.film.pad import Pad, validate_shape_keys
from squeezefilm.film.profiles import Profile, ScanFile, Sinc, StandingWave
from squeezefilm.film.scene import Actuator, Film, validate_surface_keys
from squeezefilm.film.symmetry import Symmetry, no_symmetry, symmetry
from squeezefilm.sections import BoundedNumber, KeyPath, Section, UniqueItems

if TYPE_CHECKING:
    from squeezefilm.film.measured.smooth import SmoothedScan

SMOOTHED_SCAN_ENV_VAR = "SQUEEZEFILM_SMOOTHED"
"""Of the environment: where a run keeps the smooth profile of its study's scan."""


class Solver(Section):
    """Settings of the solver.

    Attributes:
        method: `auto` takes, for each scene, the composite expansion where the squeeze number is
            large and it meets the tolerance, else the periodic state; or one by name
        tolerance: required relative error of each force
        model_tolerance: relative change of a force from which on `auto` includes a term of the
            equation
        device: OpenCL device: a part of its platform's or its own name, or `auto`. The environment
            variable `SQUEEZEFILM_DEVICE` overrides it, and the option `--device` of a command
            overrides both
    """

    method: Literal["auto", "composite", "periodic"] = "auto"
    tolerance: Annotated[float, BoundedNumber("1", 1e-10, 0.1)] = 1e-4
    model_tolerance: Annotated[float, BoundedNumber("1", 1e-6, 0.5)] = 1e-3
    device: Annotated[str, Field(min_length=1)] = "auto"


OutputName = Literal[
    "harmonics", "power", "centre", "moments", "thrust", "extremes", "static_stiffness"
]


class FilmSections(Section):
    """A film and how it is solved: what a command needs that simulates single scenes."""

    _path: Path = PrivateAttr(default=Path("study"))
    _written: Mapping[KeyPath, Any] = PrivateAttr(default_factory=dict)

    gas: GasOfStudy = Field(default={}, validate_default=True)
    actuator: Annotated[Actuator, AfterValidator(validate_surface_keys)]
    pad: Annotated[Pad, AfterValidator(validate_shape_keys)]
    solver: Solver = Field(default_factory=Solver)
    outputs: Annotated[list[OutputName], UniqueItems] = Field(
        default=[],
        description="quantities beside the mean force in every `forces.csv`, each with its error "
        "(docs/outputs.md)",
    )

    @property
    def path(self) -> Path:
        """The file of the study, from whose folder those that it names count."""
        return self._path

    @property
    def written_values(self) -> Mapping[KeyPath, Any]:
        """Values that were written, by their places; all others follow or are defaults."""
        return self._written

    def with_source(self, path: Path, values: Mapping[str, Any]) -> Self:
        """The study, which was read from these values of a file."""
        self._path, self._written = path, dict(key_paths_with_values(values))
        return self

    @property
    def scan_path(self) -> Path | None:
        """The file that the vibration shape was measured in; None if it is not a measured one."""
        profile = self.actuator.profile
        return self.path.parent / profile.file if isinstance(profile, ScanFile) else None

    @property
    def smoothing_arguments(self) -> dict[str, Any]:
        """Arguments of ``smoothed_scan_of_file`` besides the scan's file."""
        settings, surface = self.actuator.profile, self.actuator.surface
        assert isinstance(settings, ScanFile)
        frequency_hz = self.actuator.frequency_hz
        return {"settings": settings, "surface": surface, "frequency_hz": frequency_hz}

    def smoothed_scan(self, *, again: bool = False) -> "SmoothedScan | None":
        """The measured vibration shape with all that is known of it; None if it is not measured.

        In a run of the workflow as its rule `smooth` wrote it, under the name in
        SMOOTHED_SCAN_ENV_VAR, unless it is to be smoothed ``again``.
        """
        path = self.scan_path
        if path is None:
            return None
        from squeezefilm.film.measured.smoothed_file import read_smoothed_scan

        kept = Path(os.environ.get(SMOOTHED_SCAN_ENV_VAR, ""))
        if again or not kept.is_file():
            changed = (path.stat().st_mtime_ns, path.stat().st_size) if path.is_file() else ()
            return _cached_smoothed_scan(path, changed, **self.smoothing_arguments)
        return read_smoothed_scan(kept, path, **self.smoothing_arguments)

    def read_profile(self) -> Profile:
        """The vibration shape of the actuator, a measured one smoothed.

        Raises InputError naming what is wrong with a formula or a measured profile.
        """
        if smoothed := self.smoothed_scan():
            return smoothed.profile
        return self.actuator.profile.on_surface(self.actuator.surface)

    def profile_for_planning(self) -> Profile:
        """The vibration shape as far as plans need it: of a scan a usual one: it is not smoothed.

        By it the work is divided into jobs, whose number may not depend on whether the scan has
        been smoothed: a mode with a node line on the surface, of no symmetry where the scan need
        have none.
        """
        settings, surface = self.actuator.profile, self.actuator.surface
        if not isinstance(settings, ScanFile):
            return self.read_profile()
        radius_m = min(surface.half_extents_m)
        if settings.axisymmetric:
            return Sinc(wave_number_per_m=1 / radius_m)
        return StandingWave(
            wavelength_m=2 * radius_m, direction_deg=20.0, crest_m=0.1 * radius_m, surface=surface
        )

    def read_pad(self) -> Pad:
        """The pad, with the contour that its file has.

        Raises InputError naming what is wrong with the file.
        """
        pad, outline = self.pad, self.pad.outline
        if outline is None:
            return pad
        path, sides_m = self.path.parent / outline.file, (pad.length_x_m, pad.length_y_m)
        contour = read_contour(path, sides_m=sides_m, scatter_m=outline.scatter_m)
        return replace(pad, contour=contour)

    def read_film(self, *, profile: Profile | None = None) -> Film:
        """The gas, the actuator and the pad with what is in their files.

        Args:
            profile: stands in for the study's own.
        """
        profile = self.read_profile() if profile is None else profile
        return Film(self.gas, replace(self.actuator, profile=profile), self.read_pad())

    def symmetry(self) -> Symmetry:
        """The pad positions that represent all; from ``actuator`` and ``pad``.

        Of a scan the settings say it: noise leaves a shape that is free no symmetry.
        """
        settings, surface = self.actuator.profile, self.actuator.surface
        if isinstance(settings, ScanFile) and not settings.axisymmetric:
            return no_symmetry(surface)
        return symmetry(self.read_pad(), self.profile_for_planning(), surface=surface)

    def sections_as_dict(self, *names: str) -> dict[str, Any]:
        """Plain values, ready for JSON, by the names that Python has for keys (``frequency_hz``).

        Args:
            names: of sections; all without.
        """
        values = self.model_dump(include=set(names) or None, exclude_none=True)
        actuator = values.get("actuator", {})
        if "rectangle" in actuator:  # by its key, as all others are but for their units
            actuator["surface"] = actuator.pop("rectangle")
        return values


@lru_cache(maxsize=16)
def _cached_smoothed_scan(path: Path, _changed: tuple[int, ...], **settings: Any) -> "SmoothedScan":
    """The smooth profile of a scan's file, made once a process unless the file changes."""
    from squeezefilm.film.measured.smooth import smoothed_scan_of_file

    return smoothed_scan_of_file(path, **settings)


def key_paths_with_values(values: Any, key_path: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
    if isinstance(values, Mapping):
        for name, value in values.items():
            yield (*key_path, name), value
            yield from key_paths_with_values(value, (*key_path, name))
