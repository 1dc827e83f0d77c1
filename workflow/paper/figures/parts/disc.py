"""The vibration shape over the actuator's disc, for Figures 5 and 6."""

import numpy as np
import pandas as pd

from squeezefilm.studies.config import Config
from squeezefilm.studies.study import finger_of, profile_of

MEASUREMENT_NOTE = "Model only: the measured points of the original figure are not available to us."


def profile_table(config: Config, *, radii: int, angles: int) -> pd.DataFrame:
    """The profile on a polar grid over the disc, as layer ``surface``."""
    radius_m = np.linspace(0, config["actuator"]["surface_radius_m"], radii)
    angle_deg = np.linspace(0, 360, angles)
    radius_m, angle_deg = (v.ravel() for v in np.meshgrid(radius_m, angle_deg, indexing="ij"))
    x_m, y_m = radius_m * np.cos(np.radians(angle_deg)), radius_m * np.sin(np.radians(angle_deg))
    s = profile_of(config).amplitude(x_m=x_m, y_m=y_m)
    shown = np.abs(s) if np.iscomplexobj(s) else s
    return pd.DataFrame(
        {
            "layer": "surface",
            "radius_mm": np.round(radius_m * 1e3, 9),
            "angle_deg": angle_deg,
            "x_mm": np.round(x_m * 1e3, 9),
            "y_mm": np.round(y_m * 1e3, 9),
            "amplitude_ratio": np.round(shown, 12),
        }
    )


def centre_limit_mm(config: Config) -> float:
    """Largest distance of the finger's centre at which the pad is on the disc at every angle."""
    free_m = config["actuator"]["surface_radius_m"] - finger_of(config).reach_m
    return round(1e3 * float(free_m), 9)


def profile_note(config: Config) -> str:
    """The profile in words."""
    actuator = config["actuator"]
    profile, frequency = actuator["profile"], actuator["frequency_hz"] / 1e3
    if profile["kind"] == "sinc":
        shape = f"ha/hv = sinc({profile['wave_number_per_m']:g} r) (eq. 2), r in m"
        shape += ", sinc x = sin(πx)/(πx)"
    elif profile["kind"] == "measured":
        return f"Profile measured ({profile['file']}), smoothed, {frequency:g} kHz."
    elif profile["kind"] == "formula":
        return f"ha/hv ~ {profile['expression']}, {frequency:g} kHz."
    else:
        return f"Profile {profile['kind']}, {frequency:g} kHz."
    return f"{shape}, {frequency:g} kHz. {MEASUREMENT_NOTE}"
