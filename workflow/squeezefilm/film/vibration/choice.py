"""The profile that a study asks for, by its kind, where it is not a measured one (scans.py)."""

from math import isfinite
from typing import Any

from squeezefilm.film.vibration.shapes import (
    BesselMode,
    Formula,
    Piston,
    Profile,
    Sinc,
    StandingWave,
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


def make_profile(*, kind: str, surface: Surface, **settings: Any) -> Profile:
    """The profile of a config's ``actuator.profile`` section, whose keys the schema has checked.

    surface: the actuator's, over which a profile has its maximum.
    Raises InputError for a formula that is no profile, naming the place.
    """
    if kind in ("standing-wave", "bessel", "formula"):
        settings["surface"] = surface
    profile: Profile = KINDS[kind](**settings)
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
