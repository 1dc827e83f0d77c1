"""Gap and pressure along the middle of a pad over a period, for pictures."""

from contextlib import suppress

import numpy as np
import pandas as pd

from squeezefilm.errors import RunError
from squeezefilm.film.scene import Scene
from squeezefilm.quantities.pressure import gauge_pressure_and_change
from squeezefilm.reynolds.device import Device

POINTS_ALONG_X, TIMES_PER_PERIOD = 41, 16
PRESSURE_TOLERANCE = 3e-3
"""Of the largest pressure: a line of a picture is as wide."""


def cross_section(scene: Scene, *, device: Device) -> pd.DataFrame:
    """The film along y = middle of a pad: a row for each time and place.

    x_mm counts from the pad's centre along its own axis, heights from the surface at rest. The
    pressure is that of the periodic state, NaN where there is none to show. The scene's terms must
    be decided.
    """
    x = (1 - np.cos(np.pi * np.arange(POINTS_ALONG_X + 2) / (POINTS_ALONG_X + 1))) / 2
    phase = 2 * np.pi * np.arange(TIMES_PER_PERIOD) / TIMES_PER_PERIOD
    middle = np.full_like(x, 0.5)
    pad = scene.h0_m + scene.pad.gap.rise_m(x, middle)
    # The gap widens while the surface goes down.
    surface = pad - scene.h0_m * scene.gap(x, middle, phase).T
    values = np.full(surface.shape, np.nan)
    with suppress(RunError):
        gauge_pressure_ratio, _ = gauge_pressure_and_change(
            scene,
            x=x,
            y=middle[:1],
            time_points=TIMES_PER_PERIOD,
            tolerance=PRESSURE_TOLERANCE,
            device=device,
        )
        values = gauge_pressure_ratio[:, 0]
    shape = np.ones_like(surface)
    return pd.DataFrame(
        {
            "point_id": scene.point_id,
            "phase_deg": (np.degrees(phase)[:, None] * shape).ravel(),
            "x_mm": (1e3 * scene.pad.length_x_m * (x - 0.5) * shape).ravel(),
            "surface_um": 1e6 * surface.ravel(),
            "pad_um": (1e6 * pad * shape).ravel(),
            "gauge_pressure_kpa": (1e-3 * scene.gas.ambient_pressure_pa * values).ravel(),
        }
    )
