"""Gap and pressure along the middle of a finger over a period, for pictures."""

from __future__ import annotations

import numpy as np
import pandas as pd

from squeezefilm.numerics.numpy_periodic import periodic_state
from squeezefilm.scene import Scene

POINTS, TIMES = 41, 16
COLUMNS = ("point_id", "phase_deg", "x_mm", "surface_um", "finger_um", "overpressure_kpa")


def cross_section(scene: Scene) -> pd.DataFrame:
    """The film along y = middle of a finger, columns COLUMNS: a row for each time and place.

    x_mm counts from the finger's centre along its own axis, heights from the surface at rest. The
    pressure is that of the isothermal viscous film under a flat square at rest, the paper's; it is
    NaN for any other film.
    """
    x = (1 - np.cos(np.pi * np.arange(POINTS + 2) / (POINTS + 1))) / 2
    phase = 2 * np.pi * np.arange(TIMES) / TIMES
    middle = np.full_like(x, 0.5)
    amplitude = scene.amplitude(x, middle)
    # The gap widens while sin T > 0: the surface goes down.
    surface = -scene.hv_m * np.sin(phase)[:, None] * amplitude
    finger = scene.h0_m + scene.finger.gap.rise_m(x, middle)
    pressure = np.full(surface.shape, np.nan)
    if is_plain(scene):
        state = periodic_state(
            epsilon=scene.epsilon,
            sigma=scene.sigma,
            amplitude=scene.amplitude,
            nx=POINTS,
            ny=POINTS,
            nt=TIMES,
            tolerance=1e-6,
        )
        pressure[:] = 0.0
        pressure[:, 1:-1] = state.pressure[:, :, POINTS // 2] - 1
    shape = np.ones_like(surface)
    return pd.DataFrame(
        {
            "point_id": scene.point_id,
            "phase_deg": (np.degrees(phase)[:, None] * shape).ravel(),
            "x_mm": (1e3 * scene.finger.length_x_m * (x - 0.5) * shape).ravel(),
            "surface_um": 1e6 * surface.ravel(),
            "finger_um": (1e6 * finger * shape).ravel(),
            "overpressure_kpa": (1e-3 * scene.gas.ambient_pressure_pa * pressure).ravel(),
        },
        columns=list(COLUMNS),
    )


def is_plain(scene: Scene) -> bool:
    """Whether the film is the paper's: a square pad at rest, isothermal viscous flow."""
    return (
        scene.finger.shape == "rectangle"
        and scene.finger.gap.flat
        and scene.aspect == 1
        and scene.bearing_number == 0
        and scene.gas.polytropic_exponent == 1
        and len(scene.flow_coefficients) == 1
    )
