"""From a study's configuration to the things it is about."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from squeezefilm.errors import InputError
from squeezefilm.profiles.choice import make_profile
from squeezefilm.profiles.shapes import Profile
from squeezefilm.scene import Actuator, Finger, GapShape, Gas, Scene, check_scene
from squeezefilm.studies.config import Config
from squeezefilm.tables import ScenePoint

if TYPE_CHECKING:
    from squeezefilm.profiles.scans import SmoothedScan

SECTIONS = ("gas", "actuator", "finger")


def profile_of(config: Config) -> Profile:
    """The actuator's vibration shape.

    Raises:
        InputError: naming what is wrong with a formula or a measured profile.
    """
    actuator = config["actuator"]
    return make_profile(
        surface_radius_m=actuator["surface_radius_m"],
        folder=config.path.parent,
        **actuator["profile"],
    )


def scan_path(config: Config) -> Path | None:
    """The file that the vibration shape was measured in; None if it is not a measured one."""
    profile = config["actuator"]["profile"]
    return config.path.parent / profile["file"] if profile["kind"] == "measured" else None


def smoothed_scan_of(config: Config) -> SmoothedScan | None:
    """The measured vibration shape with all that is known of it; None if it is not measured."""
    from squeezefilm.profiles.scans import smoothed_scan

    path = scan_path(config)
    if path is None:
        return None
    actuator = config["actuator"]
    return smoothed_scan(
        path,
        surface_radius_m=actuator["surface_radius_m"],
        **{key: value for key, value in actuator["profile"].items() if key not in ("kind", "file")},
    )


def finger_of(config: Config) -> Finger:
    """The finger pad."""
    keys = dict(config["finger"])
    return Finger(gap=GapShape(**keys.pop("gap")), **keys)


def scene_of(point: ScenePoint, config: Config) -> Scene:
    """The scene of one point of a plan on the study's film, checked.

    Raises:
        InputError: naming the point and the factor that has no physical meaning.
    """
    actuator = config["actuator"]
    scene = Scene(
        point_id=point.point_id,
        h0_m=point.h0_m,
        hv_m=point.hv_m,
        phi_r_m=point.phi_r_m,
        phi_deg=point.phi_deg,
        gas=Gas(**config["gas"]),
        actuator=Actuator(
            frequency_hz=actuator["frequency_hz"],
            surface_radius_m=actuator["surface_radius_m"],
            profile=profile_of(config),
        ),
        finger=finger_of(config),
    )
    check_scene(scene)
    return scene


def check_study(config: Config) -> Config:
    """Check every finger position and film of a study before anything is simulated.

    Raises:
        InputError: naming the section and the point that has no physical meaning.
    """
    screen, extrapolation = config["screen"], config["extrapolation"]
    gap, amplitude = screen["h0_m"]["start"], screen["hv_m"]["stop"]
    centre = {"phi_r_m": 0.0, "phi_deg": 0.0}
    points = [
        ("screen", ScenePoint("smallest gap, largest amplitude", gap, amplitude, **centre)),
        (
            "extrapolation",
            ScenePoint("wanted", extrapolation["h0_m"], extrapolation["hv_m"], **centre),
        ),
    ]
    for radius in config["positions"]["phi_r_m"]:
        for angle in config["positions"]["phi_deg"]:
            name = f"({radius:g} m, {angle:g}°)"
            points.append(("positions", ScenePoint(name, gap, amplitude, radius, angle)))
    for section, point in points:
        try:
            scene_of(point, config)
        except InputError as error:
            raise InputError(f"{config.path}: {section}: {error}") from None
    return config
