"""The pressure under a finger as an xarray data set."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from squeezefilm.errors import InputError, needing
from squeezefilm.film.scene import Scene
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.quantities.pressure import pressure
from squeezefilm.reynolds.device import Device
from squeezefilm.studies.solver_settings import SolverSettings

if TYPE_CHECKING:
    import xarray

LEAST_PLACES, MOST_PLACES = 3, 1001
LEAST_INSTANTS, MOST_INSTANTS = 4, 1024
TOLERANCE = 1e-4
"""Of the largest overpressure, where none is given."""


def field_of(
    scene: Scene,
    *,
    settings: SolverSettings,
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
        [scene], model_tolerance=settings.model_tolerance, method="periodic", device=device
    )
    across = np.linspace(0.0, 1.0, places)
    found = pressure(
        scene, x=across, y=across, instants=instants, tolerance=tolerance, device=device
    )
    phase = 2 * np.pi * np.arange(instants) / instants
    x, y = np.meshgrid(across, across)
    gap_m = scene.h0_m * np.moveaxis(scene.gap(x, y, phase), -1, 0)
    outside = np.isnan(found.values)
    ambient, finger = scene.gas.ambient_pressure_pa, scene.finger
    axes = ("phase", "y", "x")
    return xarray.Dataset(
        {
            "overpressure": (
                axes,
                ambient * found.values,
                {"units": "Pa", "long_name": "pressure above ambient"},
            ),
            "gap": (
                axes,
                np.where(outside, np.nan, gap_m),
                {"units": "m", "long_name": "gap between surface and finger"},
            ),
        },
        coords={
            "phase": ("phase", np.degrees(phase), {"units": "degree", "long_name": "phase"}),
            "y": ("y", finger.length_y_m * (across - 0.5), {"units": "m", **_axis("y")}),
            "x": ("x", finger.length_x_m * (across - 0.5), {"units": "m", **_axis("x")}),
            "time": (
                "phase",
                phase / scene.actuator.angular_frequency_rad_per_s,
                {"units": "s", "long_name": "time"},
            ),
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


def _axis(name: str) -> dict[str, str]:
    return {"long_name": f"from the finger's centre along its own {name} axis"}
