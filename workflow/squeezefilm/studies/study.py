"""From a study's configuration to the things it is about."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan2, degrees, hypot
from pathlib import Path
from typing import TYPE_CHECKING

from squeezefilm.film.directions import Directions, Symmetry
from squeezefilm.film.scene import Actuator, Finger, GapShape, Gas, Scene, check_scene
from squeezefilm.film.vibration.choice import make_profile
from squeezefilm.film.vibration.shapes import Profile
from squeezefilm.film.vibration.surfaces import Disc, Rectangle, Surface
from squeezefilm.io.errors import naming
from squeezefilm.io.tables import ScenePoint
from squeezefilm.studies.config import Config
from squeezefilm.studies.symmetry import symmetry

if TYPE_CHECKING:
    from squeezefilm.film.vibration.scans import SmoothedScan

SECTIONS = ("gas", "actuator", "finger")


def surface_of(config: Config) -> Surface:
    """The surface that vibrates."""
    actuator = config["actuator"]
    if "surface_radius_m" in actuator:
        return Disc(actuator["surface_radius_m"])
    return Rectangle(actuator["surface"]["length_x_m"], actuator["surface"]["length_y_m"])


def profile_of(config: Config) -> Profile:
    """The actuator's vibration shape.

    Raises InputError naming what is wrong with a formula or a measured profile.
    """
    smoothed = smoothed_scan_of(config)
    if smoothed is not None:
        return smoothed.profile
    return make_profile(surface=surface_of(config), **config["actuator"]["profile"])


def scan_path(config: Config) -> Path | None:
    """The file that the vibration shape was measured in; None if it is not a measured one."""
    profile = config["actuator"]["profile"]
    return config.path.parent / profile["file"] if profile["kind"] == "measured" else None


def smoothed_scan_of(config: Config) -> SmoothedScan | None:
    """The measured vibration shape with all that is known of it; None if it is not measured."""
    from squeezefilm.film.vibration.scans import smoothed_scan

    path = scan_path(config)
    if path is None:
        return None
    settings = config["actuator"]["profile"]
    return smoothed_scan(
        path,
        surface=surface_of(config),
        **{key: value for key, value in settings.items() if key not in ("kind", "file")},
    )


def finger_of(config: Config) -> Finger:
    """The finger pad."""
    keys = dict(config["finger"])
    return Finger(gap=GapShape(**keys.pop("gap")), **keys)


def symmetry_of(config: Config) -> Symmetry:
    """The finger positions that represent all; from ``actuator`` and ``finger``."""
    return symmetry(finger_of(config), profile_of(config), surface=surface_of(config))


def scene_of(point: ScenePoint, config: Config, *, check: bool = True) -> Scene:
    """The scene of one point of a plan on the study's film, checked unless only its terms matter.

    Raises InputError naming the point and the factor that has no physical meaning.
    """
    scene = Scene(
        point_id=point.point_id,
        h0_m=point.h0_m,
        hv_m=point.hv_m,
        x_m=point.x_m,
        y_m=point.y_m,
        gas=Gas(**config["gas"]),
        actuator=Actuator(
            frequency_hz=config["actuator"]["frequency_hz"],
            surface=surface_of(config),
            profile=profile_of(config),
        ),
        finger=finger_of(config),
    )
    if check:
        check_scene(scene)
    return scene


def check_study(config: Config) -> Config:
    """Check every finger position and film of a study before anything is simulated.

    Raises InputError naming the section and the point that has no physical meaning.
    """
    for section, point in _extreme_points(config):
        with naming(f"{config.path}: {section}"):
            scene_of(point, config)
    return config


def _extreme_points(config: Config) -> Iterator[tuple[str, ScenePoint]]:
    """The points of a study at which a film may fail to exist, each with its section."""
    screen, extrapolation = config["screen"], config["extrapolation"]
    gap, amplitude = screen["h0_m"]["start"], screen["hv_m"]["stop"]
    yield "screen", ScenePoint("smallest gap, largest amplitude", gap, amplitude)
    yield "extrapolation", ScenePoint("wanted", extrapolation["h0_m"], extrapolation["hv_m"])
    found, positions = symmetry_of(config), config["positions"]
    places = found.places(positions)
    if isinstance(found, Directions):
        # Designs and control points may lie between the directions given: also where the pad's
        # farthest point is farthest out.
        x_m, y_m = max(finger_of(config).outline(), key=lambda place: hypot(*place))
        farthest = float(found.fold(degrees(atan2(y_m, x_m))))
        places += [(radius, farthest) for radius in positions["phi_r_m"]]
    for place in places:
        factors = dict(zip(found.position, place, strict=True))
        name = ", ".join(f"{key} = {value:g}" for key, value in factors.items())
        point = ScenePoint.of(f"({name})", h0_m=gap, hv_m=amplitude, **factors)
        yield "positions", point
