"""Data of Figure 5: the profile over the disc, the finger and the limit of its centre."""

from __future__ import annotations

import numpy as np
import pandas as pd

from squeezefilm.config import Config
from squeezefilm.figure_data import disc
from squeezefilm.figure_data.common import Inputs

INPUTS: tuple[str, ...] = ()
SECTIONS = ("actuator", "finger")


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers surface (polar grid), centre_limit (a circle) and finger (its outline, centred)."""
    finger, limit_mm = config["finger"], disc.centre_limit_mm(config)
    x_mm, y_mm = finger["length_x_m"] * 500, finger["length_y_m"] * 500
    outline = pd.DataFrame(
        {
            "layer": "finger",
            "x_mm": [-x_mm, x_mm, x_mm, -x_mm, -x_mm],
            "y_mm": [-y_mm, -y_mm, y_mm, y_mm, -y_mm],
        }
    )
    angle_deg = np.linspace(0, 360, 121)
    circle = pd.DataFrame(
        {
            "layer": "centre_limit",
            "radius_mm": limit_mm,
            "angle_deg": angle_deg,
            "x_mm": np.round(limit_mm * np.cos(np.radians(angle_deg)), 9),
            "y_mm": np.round(limit_mm * np.sin(np.radians(angle_deg)), 9),
        }
    )
    surface = disc.profile_table(config, radii=41, angles=61)
    note = (
        f"{disc.profile_note(config)} The finger, {2 * x_mm:g} mm × {2 * y_mm:g} mm, stays on the "
        f"disc at every angle while its centre is within {limit_mm:.2f} mm."
    )
    return pd.concat([surface, circle, outline], ignore_index=True).assign(note=note)
