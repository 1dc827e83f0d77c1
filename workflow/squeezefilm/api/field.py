"""The pressure under a finger as an xarray data set."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from squeezefilm.errors import InputError, needing
from squeezefilm.film.scene import Scene
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.quantities.pressure import pressure
from squeezefilm.reynolds.device import Device

if TYPE_CHECKING:
    import xarray

LEAST_PLACES, MOST_PLACES = 3, 1001
LEAST_INSTANTS, MOST_INSTANTS = 4, 1024
DESCRIBED = {
    "overpressure": ("Pa", "pressure above ambient"),
    "gap": ("m", "gap between surface and finger"),
    "phase": ("degree", "phase"),
    "y": ("m", "from the finger's centre along its own y axis"),
    "x": ("m", "from the finger's centre along its own x axis"),
    "time": ("s", "time"),
}
TOLERANCE = 1e-4
"""Of the largest overpressure, where none is given."""


def field_of(
    scene: Scene,
    *,
    model_tolerance: float,
    device: Device,
    places: int,
    instants: int,
    tolerance: float,
) -> xarray.Dataset:
    """Overpressure and gap over one period at evenly spaced places under the finger.

    Raises InputError for numbers out of range or without xarray, RunError where there is no state.
    """
    with needing("fields", what="a pressure field"):
        import xarray
    for name, value, least, most in (
        ("places", places, LEAST_PLACES, MOST_PLACES),
        ("instants", instants, LEAST_INSTANTS, MOST_INSTANTS),
    ):
        if not least <= value <= most:
            raise InputError(f"{name}: {value} must lie within {least} … {most}")
    if instants % 2:
        raise InputError(f"instants: {instants} must be even")
    if not 1e-8 <= tolerance <= 0.1:
        raise InputError(f"tolerance: {tolerance:g} must lie between 1e-8 and 0.1")
    (scene,) = resolve_auto_terms(
        [scene], model_tolerance=model_tolerance, method="periodic", device=device
    )
    across = np.linspace(0.0, 1.0, places)
    found = pressure(
        scene, x=across, y=across, instants=instants, tolerance=tolerance, device=device
    )
    phase = 2 * np.pi * np.arange(instants) / instants
    gap_m = scene.h0_m * np.moveaxis(scene.gap(*np.meshgrid(across, across), phase), -1, 0)
    ambient, finger, axes = scene.gas.ambient_pressure_pa, scene.finger, ("phase", "y", "x")
    field = xarray.Dataset(
        {
            "overpressure": (axes, ambient * found.values),
            "gap": (axes, np.where(np.isnan(found.values), np.nan, gap_m)),
        },
        coords={
            "phase": np.degrees(phase),
            "y": finger.length_y_m * (across - 0.5),
            "x": finger.length_x_m * (across - 0.5),
            "time": ("phase", phase / scene.actuator.angular_frequency_rad_per_s),
        },
        attrs={
            "title": "pressure of a squeeze film over one period",
            "h0_m": scene.h0_m,
            "hv_m": scene.hv_m,
            "finger_x_m": scene.x_m,
            "finger_y_m": scene.y_m,
            "frequency_hz": scene.actuator.frequency_hz,
            "ambient_pressure_pa": ambient,
            "inertia": scene.gas.inertia,
            "change_pa": ambient * found.change,
            "comment": "change_pa: most that a pressure changed by in the last refinement",
        },
    )
    for name, (unit, words) in DESCRIBED.items():
        field[name].attrs |= {"units": unit, "long_name": words}
    return field
