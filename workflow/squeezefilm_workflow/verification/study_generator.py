"""Random studies: film, gas, vibration and ranges, each drawn from a seed as a configuration."""

import json
from math import cos, hypot, pi, radians, sin
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.api.models import Study
from squeezefilm.config.loading import parse_config
from squeezefilm_workflow.verification.random_films import log_uniform

# Of the vibration.
WAVELENGTH_RANGE_M = (3e-3, 30e-3)
# Length of the pad along x; of UNUSUAL_STUDY_FRACTION studies.
PAD_LENGTH_RANGE_M, SMALL_PAD_LENGTH_RANGE_M = (4e-3, 15e-3), (20e-6, 4e-3)
# Smallest gap of the study's range; of UNUSUAL_STUDY_FRACTION studies.
SMALLEST_GAP_RANGE_M, UNUSUAL_SMALLEST_GAP_RANGE_M = (1.5e-6, 15e-6), (20e-9, 100e-6)
FREQUENCY_RANGE_HZ = (5e3, 1e5)
DRAWN_TOLERANCES = (1e-3, 1e-3, 1e-4)
# Share of studies whose pad is small, and as many whose gap is unusual: limits of validity.
UNUSUAL_STUDY_FRACTION = 0.15

VIBRATION_KINDS = ("bessel", "standing-wave", "travelling-wave", "piston")
# Probabilities of VIBRATION_KINDS, by the kind of study.
PROBABILITIES_OF_KIND = {
    "any": (0.4, 0.25, 0.2, 0.15),
    "disc": (1.0, 0.0, 0.0, 0.0),
    "plate": (0.0, 0.6, 0.4, 0.0),
    "scan": (0.5, 0.5, 0.0, 0.0),
}
# Points of a scan across the surface, and their noise over the largest amplitude.
SCAN_POINTS_ACROSS, SCAN_NOISE_FRACTION = 61, 0.01


def random_study(seed: int, *, folder: Path, kind: str = "any", **settings: Any) -> Study:
    """The study of a seed.

    Args:
        folder: where the file of a measured vibration is written.
        kind: one of PROBABILITIES_OF_KIND; a scan is that of a disc or a plate.
        settings: sections of its configuration that are not drawn.
    """
    values = random_study_values(seed, kind=kind) | settings
    if kind == "scan":
        file = folder / f"{values['study']}.csv"
        file.write_text(
            _simulated_scan_csv(_study_of_values(values, folder), seed), encoding="utf-8"
        )
        values["actuator"]["profile"] = {"kind": "measured", "file": file.name}
    return _study_of_values(values, folder)


def _study_of_values(values: dict[str, Any], folder: Path) -> Study:
    return Study(parse_config(json.dumps(values), path=folder / f"{values['study']}.yaml"))


def random_study_values(seed: int, *, kind: str = "any") -> dict[str, Any]:
    """The configuration of a seed's study, as a file would have it; of a scan what is scanned."""
    random = np.random.default_rng(seed)
    pad = _random_pad(random)
    gap_m = log_uniform(
        random,
        UNUSUAL_SMALLEST_GAP_RANGE_M
        if random.uniform() < UNUSUAL_STUDY_FRACTION
        else SMALLEST_GAP_RANGE_M,
    )
    amplitude_m = random.uniform(0.1, 0.85) * gap_m
    return {
        "study": f"random-{seed}",
        "gas": _random_gas(random),
        "actuator": _random_actuator(random, pad, PROBABILITIES_OF_KIND[kind]),
        "pad": pad,
        "screen": {
            "h0": {"start": gap_m, "stop": random.uniform(1.3, 2.5) * gap_m, "levels": 5},
            "hv": {
                "start": random.uniform(0.05, 0.5) * amplitude_m,
                "stop": amplitude_m,
                "levels": 5,
            },
        },
        "extrapolation": {"force": 1.0},
        "solver": {"tolerance": float(random.choice(DRAWN_TOLERANCES))},
    }


def _random_gas(random: np.random.Generator) -> dict[str, Any]:
    """Air under some pressure, or another gas."""
    gas: dict[str, Any] = {
        "ambient_pressure": log_uniform(random, (3e4, 5e5)),
        "rarefaction": str(random.choice(["none", "none", "slip", "fukui-kaneko"])),
        **{term: str(random.choice(["auto", "auto", "none"])) for term in ("inertia", "thermal")},
    }
    if random.uniform() < 0.5:
        return gas
    return gas | {
        "viscosity": log_uniform(random, (8e-6, 3e-5)),
        "density": log_uniform(random, (0.1, 6.0)),
        "mean_free_path": log_uniform(random, (2e-8, 3e-7)),
        "prandtl": random.uniform(0.6, 0.8),
        "heat_capacity_ratio": random.uniform(1.1, 1.66),
        "viscosity_exponent": random.uniform(0.6, 1.0),
    }


def _random_pad(random: np.random.Generator) -> dict[str, Any]:
    """A square, a rectangle, a disc or an ellipse, turned by any angle."""
    length_m = log_uniform(
        random,
        SMALL_PAD_LENGTH_RANGE_M
        if random.uniform() < UNUSUAL_STUDY_FRACTION
        else PAD_LENGTH_RANGE_M,
    )
    aspect = float(random.choice([1.0, log_uniform(random, (0.5, 2.0))]))
    return {
        "shape": str(random.choice(["rectangle", "rectangle", "ellipse"])),
        "length_x": length_m,
        "length_y": aspect * length_m,
        "rotation": float(random.choice([0.0, random.uniform(0, 90)])),
    }


def _random_actuator(
    random: np.random.Generator, pad: dict[str, Any], probabilities: tuple[float, ...]
) -> dict[str, Any]:
    """A disc in a bending mode, a plate with a wave, or one of both that moves as a piston.

    The surface has room for the pad and as much again.
    """
    wavelength_m = log_uniform(random, WAVELENGTH_RANGE_M)
    reach_m = hypot(pad["length_x"], pad["length_y"]) / 2
    direction_deg = float(random.choice([0.0, random.uniform(0, 180)]))
    kind = str(random.choice(VIBRATION_KINDS, p=probabilities))
    profile: dict[str, Any] = {"kind": kind}
    if kind == "bessel":
        n = int(random.integers(0, 4))
        profile |= {"nodal_diameters": n, "wave_number": 2 * pi / wavelength_m}
        profile |= {"direction": direction_deg}
    elif kind != "piston":
        profile |= {"wavelength": wavelength_m, "direction": direction_deg}
    if kind == "standing-wave":
        profile |= {"crest": random.uniform(0, 0.5) * wavelength_m}
    room = random.uniform(1.2, 2.5)
    surface: dict[str, Any] = {"surface_radius": room * reach_m}
    if kind != "bessel":
        angle = radians(pad["rotation"])
        x, y = pad["length_x"] / 2, pad["length_y"] / 2
        c, s = abs(cos(angle)), abs(sin(angle))
        sides = {"length_x": 2 * room * (c * x + s * y), "length_y": 2 * room * (s * x + c * y)}
        surface = {"surface": {"shape": "rectangle", **sides}}
    return {"frequency": log_uniform(random, FREQUENCY_RANGE_HZ), **surface, "profile": profile}


def _simulated_scan_csv(study: Study, seed: int) -> str:
    """A vibrometer's table of a study's vibration: a raster over its surface, with noise."""
    random = np.random.default_rng(seed)
    surface = study.config.actuator.surface
    sides = (np.linspace(-half_m, half_m, SCAN_POINTS_ACROSS) for half_m in surface.half_extents_m)
    x, y = (values.ravel() for values in np.meshgrid(*sides))
    on_it = surface.relative_distance(x, y) <= 1
    x, y = x[on_it], y[on_it]
    shape = study.config.read_profile().amplitude(x_m=x, y_m=y)
    measured = shape + SCAN_NOISE_FRACTION * random.standard_normal(len(x))
    columns = {"x_mm": 1e3 * x, "y_mm": 1e3 * y, "amplitude_um": np.abs(measured)}
    table = pd.DataFrame(columns).round({"x_mm": 4, "y_mm": 4, "amplitude_um": 5})
    return table.assign(phase_deg=np.where(measured < 0, 180, 0)).to_csv(index=False)
