"""Data of Figure 5: the profile over the disc, the finger and the limit of its centre."""

from __future__ import annotations

import numpy as np
import pandas as pd

from paper.figure_data import disc
from reporting.figure_data.common import Inputs
from squeezefilm.studies.config import Config
from squeezefilm.studies.study import finger_of

INPUTS: tuple[str, ...] = ()
SECTIONS = ("actuator", "finger")


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers surface (polar grid), centre_limit (a circle) and finger (its outline, centred)."""
    finger, limit_mm = finger_of(config), disc.centre_limit_mm(config)
    rim = np.round(np.array(finger.outline()) * 1e3, 9)
    closed = np.vstack([rim, rim[:1]])
    outline = pd.DataFrame({"layer": "finger", "x_mm": closed[:, 0], "y_mm": closed[:, 1]})
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
        f"{disc.profile_note(config)} The finger, {finger.length_x_m * 1e3:g} mm × "
        f"{finger.length_y_m * 1e3:g} mm, stays on the "
        f"disc at every angle while its centre is within {limit_mm:.2f} mm."
    )
    return pd.concat([surface, circle, outline], ignore_index=True).assign(note=note)
