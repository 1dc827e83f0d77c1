"""Gaps of a film under loads, for the command line and for ``Film.levitate``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

from squeezefilm.api.film import FactorValues, Film, parse_factor_values
from squeezefilm.api.forces import scan_error_function
from squeezefilm.dynamics.levitation_tables import Load, levitation_rows
from squeezefilm.errors import InputError
from squeezefilm.film.scene import Scenes
from squeezefilm.film.validity import GAP_RANGE_M

DEFAULT_AMPLITUDE_RANGE_M = (1e-9, 1e-4)
GRAVITY_M_PER_S2 = 9.80665
DEFAULT_FREQUENCIES_TEXT = "10Hz,30Hz,100Hz,300Hz,1000Hz"


def parse_loads(
    load: FactorValues | None, mass: FactorValues | None, *, option: str = "{}"
) -> list[Load]:
    """Return each load with each mass, or the weight of each mass.

    Args:
        option: how a name is written in messages.

    Raises InputError for neither, and for what is not positive.
    """
    values_of: dict[str, list[float]] = {}
    for name, values, unit in (("load", load, "N"), ("mass", mass, "kg")):
        if values is not None:
            called = option.format(name)
            try:
                values_of[name] = parse_factor_values(values, called=called, unit=unit)
            except InputError as error:
                raise InputError(f"{error}{_other_quantity_hint(values, name, option)}") from None
            if min(values_of[name]) <= 0:
                raise InputError(f"{called} {values!r} must be positive")
    if not values_of:
        raise InputError(f"give {option.format('load')} or {option.format('mass')}")
    if "load" in values_of:
        return [Load(*each) for each in product(values_of["load"], values_of.get("mass", [None]))]
    return [Load(GRAVITY_M_PER_S2 * mass_kg, mass_kg) for mass_kg in values_of["mass"]]


def _other_quantity_hint(values: FactorValues, name: str, option: str) -> str:
    """Return a hint where a load is written as a mass or a mass as a load; empty otherwise."""
    other, unit = {"load": ("mass", "kg"), "mass": ("load", "N")}[name]
    try:
        parse_factor_values(values, called=other, unit=unit)
    except InputError:
        return ""
    return f"; did you mean {option.format(other)}?"


def levitation_scenes(
    film: Film, points: Mapping[str, Sequence[float]], *, option: str = "{}"
) -> Scenes:
    """Return the scenes of amplitudes and positions, at the largest gap: there is no contact.

    Raises InputError for an amplitude out of range.
    """
    least, most = DEFAULT_AMPLITUDE_RANGE_M
    for hv_m in points["hv_m"]:
        if not least <= hv_m <= most:
            raise InputError(
                f"{option.format('hv')}: {1e6 * hv_m:g} µm must lie within {1e6 * least:g} … "
                f"{1e6 * most:g} µm"
            )
    return film.scenes({**points, "h0_m": (GAP_RANGE_M[1],) * len(points["hv_m"])})


def levitations(film: Film, scenes: Scenes, loads: Sequence[Load]) -> Iterator[dict[str, Any]]:
    """Yield a row for each scene and load, with its gap, as soon as it is known."""
    off_n = scan_error_function(film.scan, device=film.device)
    how = film.solver().levitation_arguments
    yield from levitation_rows(scenes, loads, how=how, scan_error_n=off_n)
