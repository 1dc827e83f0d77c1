"""The profile that a study asks for, by its kind, where it is not a measured one (scans.py)."""

from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from squeezefilm.film.vibration.shapes import (
    BesselMode,
    Formula,
    Piston,
    Profile,
    Sinc,
    StandingWave,
    TwoPhases,
    Vibration,
    largest_magnitude,
    largest_of_formula,
    largest_radial,
)
from squeezefilm.film.vibration.surfaces import Surface
from squeezefilm.io.errors import InputError

KINDS: dict[str, type] = {
    "sinc": Sinc,
    "piston": Piston,
    "standing-wave": StandingWave,
    "bessel": BesselMode,
    "formula": Formula,
}


def make_profile(*, kind: str, surface: Surface, **settings: Any) -> Vibration:
    """The profile of a config's ``actuator.profile`` section, whose keys the schema has checked.

    surface: the actuator's, over which a profile has its maximum.
    Raises InputError for a formula that is no profile, naming the place.
    """
    if kind == "travelling-wave":
        # sin T cos ku − cos T sin ku = sin(T − ku): it travels towards larger u.
        wave = StandingWave(**settings, crest_m=0.0)
        return TwoPhases(wave, replace(wave, crest_m=-wave.wavelength_m / 4))
    quadrature = settings.pop("quadrature", None)
    if quadrature is not None:
        return _in_two_phases(
            Formula(**settings, surface=surface), Formula(quadrature, surface=surface)
        )
    if kind in ("standing-wave", "bessel", "formula"):
        settings["surface"] = surface
    return _with_maximum(KINDS[kind](**settings), kind=kind, surface=surface)


def _with_maximum(profile: Profile, *, kind: str, surface: Surface) -> Profile:
    """The profile, if its maximum on the surface is a number above zero."""
    size = 1.0
    if isinstance(profile, Formula):
        size = largest_of_formula(profile)
    if isinstance(profile, BesselMode):
        size = largest_radial(profile)
    if not (isfinite(size) and size > 0):
        raise InputError(
            f"actuator.profile: the {kind} has no finite value everywhere on the "
            f"{surface.text}, or is zero on all of it"
        )
    return profile


def _in_two_phases(first: Formula, second: Formula) -> Vibration:
    """Both formulas over the largest √(first² + second²) on the surface; one if the other is 0."""
    sizes = largest_of_formula(first), largest_of_formula(second)
    if sizes[1] == 0:
        return _with_maximum(first, kind="formula", surface=first.surface)
    _with_maximum(second, kind="formula", surface=second.surface)
    if sizes[0] == 0:  # it is when it is a quarter of a period later
        return second
    _with_maximum(first, kind="formula", surface=first.surface)
    both = largest_magnitude(
        lambda x_m, y_m: np.hypot(
            sizes[0] * first.amplitude(x_m=x_m, y_m=y_m),
            sizes[1] * second.amplitude(x_m=x_m, y_m=y_m),
        ),
        surface=first.surface,
    )
    return TwoPhases(first, second, shares=(sizes[0] / both, sizes[1] / both))
