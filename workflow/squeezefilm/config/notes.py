"""Notes on a study that is valid and probably not what was meant."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from squeezefilm.config.film import FilmSections
from squeezefilm.film.pad import Pad
from squeezefilm.film.profiles import Sinc, StandingWave
from squeezefilm.film.scene import Actuator
from squeezefilm.sections import KeyPath, key_of_name
from squeezefilm.units import quantity_and_unit_of_column

if TYPE_CHECKING:
    from squeezefilm.config.study import Study

USUAL_RANGE_AND_INPUT_UNIT = {"Hz": (1e3, math.inf, "kHz"), "m": (0.0, 1.0, "mm")}
"""Range of a study's frequencies and lengths, and the unit that people give them in."""
PAPERS_ACTUATOR = Actuator(43.27e3, 10e-3, profile=Sinc(wave_number_per_m=109.8))
PAPERS_PAD = Pad(10e-3, 10e-3)
"""The film whose claims, tables and figures a study with ``paper: true`` makes."""
PAPERS_GAS_SETTINGS = {"rarefaction": "none", "polytropic_exponent": 1, "inertia": "none"}
PAPERS_GAS_SETTINGS |= {"thermal": "none"}


def differences_from_paper(config: Study) -> Iterator[str]:
    """Yield what makes the film of a study another than the paper's, by its keys."""
    for name, papers in (("actuator", PAPERS_ACTUATOR), ("pad", PAPERS_PAD)):
        if getattr(config, name) != papers:
            yield f"another {name}"
    for key, value in PAPERS_GAS_SETTINGS.items():
        if (own := getattr(config.gas, key)) != value:
            yield f"gas.{key} {own}"


def study_notes(config: Study) -> Iterator[str]:
    """Yield notes on what is valid and probably not meant.

    ``unit_notes``, ``target_force_notes``, a study with the name of another file's, of the paper
    with another film, a standing wave without a model that repeats along it.
    """
    namesake = config.path.with_name(f"{config.study}.yaml")
    if namesake.name != config.path.name and namesake.exists():
        yield (
            f"study: {config.study} is the study of {namesake}: results/{config.study} would hold "
            f"the results of both; write another name, such as {config.path.stem}"
        )
    if config.paper and (changes := list(differences_from_paper(config))):
        yield (
            f"paper: true, but {', '.join(changes)}: its pages name a variant of the paper; leave "
            "paper out where the paper's claims are not to be compared"
        )
    yield from target_force_notes(config)
    if isinstance(config.actuator.profile, StandingWave) and not config.models:
        yield (
            "models: the force repeats along a standing wave, and formulas in x**2 + y**2 do not; "
            "add one with cos(4*pi*x/wavelength) (docs/reference/formulas.md)"
        )
    yield from unit_notes(config)


def unit_notes(config: FilmSections) -> Iterator[str]:
    """Yield notes on numbers without a unit that lie outside USUAL_RANGE_AND_INPUT_UNIT."""
    for key_path, unit in units_of_numbers(config.sections_as_dict()):
        yield from unit_notes_of_value(key_path, config.written_values.get(key_path), unit)


def unit_notes_of_value(key_path: KeyPath, value: Any, unit: str) -> Iterator[str]:
    """Yield a note on a number without a unit that lies outside USUAL_RANGE_AND_INPUT_UNIT."""
    if unit in USUAL_RANGE_AND_INPUT_UNIT and isinstance(value, int | float):
        least, most, meant = USUAL_RANGE_AND_INPUT_UNIT[unit]
        if not least <= abs(value) <= most:
            key = ".".join(map(str, key_path))
            yield f"{key} is read as {value:g} {unit}; for {value:g} {meant} write the unit"


def units_of_numbers(
    values: Mapping[str, Any], key_path: KeyPath = (), unit: str = ""
) -> Iterator[tuple[KeyPath, str]]:
    """Yield the key of each number and its unit, which its name or its section's ends in.

    The JSON schema has them too, and takes longer to make than a small film to solve.
    """
    for name, value in values.items():
        here, own = (*key_path, key_of_name(name)), quantity_and_unit_of_column(name)[1] or unit
        if isinstance(value, Mapping):
            yield from units_of_numbers(value, here, own)
        elif isinstance(value, float):
            yield here, own


def target_force_notes(config: Study) -> Iterator[str]:
    """Yield a note where no amplitude of the screen gives the target force.

    As σ → ∞ a film with a parallel gap gives at most the force of a piston,
    p0 A (√((1 + 3/2 ε²)/(1 − ε²)) − 1), without inertia and thermal effects.
    """
    target, hv_m = config.extrapolation, config.screen.hv_m.stop
    ratio_squared = (hv_m / target.h0_m) ** 2
    if ratio_squared >= 1 or not config.pad.gap.flat:
        return
    pressure_ratio = math.sqrt((1 + 1.5 * ratio_squared) / (1 - ratio_squared)) - 1
    limit_n = config.gas.ambient_pressure_pa * config.pad.area_m2 * pressure_ratio
    if target.force_n > limit_n:
        yield (
            f"extrapolation.force: {target.force_n:g} N is beyond the screen: at h0 = "
            f"{1e6 * target.h0_m:g} µm and hv = {1e6 * hv_m:g} µm no film gives more than about "
            f"{limit_n:.2g} N without inertia and thermal effects; "
            "recommended amplitudes would not be validated"
        )
