"""From a study's configuration to the things it is about."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from math import atan2, degrees, hypot
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from squeezefilm.columns import POLAR
from squeezefilm.config.loading import Config
from squeezefilm.errors import InputError, naming
from squeezefilm.film.finger import Finger, GapShape
from squeezefilm.film.outline import read_contour
from squeezefilm.film.profiles import Profile, Sinc, StandingWave, make_profile
from squeezefilm.film.scene import Actuator, Film, Gas, Scene, Scenes
from squeezefilm.film.surfaces import Disc, Rectangle, Surface
from squeezefilm.film.symmetry import Directions, Symmetry, no_symmetry, symmetry
from squeezefilm.film.validity import check_scene, check_scenes
from squeezefilm.tables import FACTOR_COLUMNS, ScenePoint, as_in

if TYPE_CHECKING:
    import pandas as pd

    from squeezefilm.film.measured.smooth import SmoothedScan

SMOOTHED_VARIABLE = "SQUEEZEFILM_SMOOTHED"
"""Of the environment: where a run keeps the smooth profile of its study's scan."""


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


def outline_path(config: Config) -> Path | None:
    """The file of the finger's outline; None if it is not given by one."""
    outline = config["finger"].get("outline")
    return config.path.parent / outline["file"] if outline else None


def smoothing_settings(config: Config) -> dict[str, Any]:
    """What decides how a scan is smoothed, besides its file: arguments of ``smoothed_scan``."""
    actuator = config["actuator"]
    return {
        "surface": surface_of(config),
        "frequency_hz": actuator["frequency_hz"],
        **{key: value for key, value in actuator["profile"].items() if key not in ("kind", "file")},
    }


def smoothed_anew(config: Config) -> SmoothedScan:
    """The smooth profile of a study's scan."""
    from squeezefilm.film.measured.smooth import smoothed_scan

    path = scan_path(config)
    assert path is not None
    return smoothed_scan(path, **smoothing_settings(config))


def smoothed_scan_of(config: Config) -> SmoothedScan | None:
    """The measured vibration shape with all that is known of it; None if it is not measured.

    In a run of the workflow as its rule `smooth` wrote it, under the name in SMOOTHED_VARIABLE.
    """
    path = scan_path(config)
    if path is None:
        return None
    kept = Path(os.environ.get(SMOOTHED_VARIABLE, ""))
    if not kept.is_file():
        return smoothed_anew(config)
    from squeezefilm.film.measured.smooth import read_smoothed

    return read_smoothed(kept, path, settings=smoothing_settings(config))


def planned_profile_of(config: Config) -> Profile:
    """The vibration shape as far as plans need it: of a scan a usual one, for it is not smoothed.

    By it the work is divided into jobs, whose number may not depend on whether the scan has been
    smoothed: a mode with a node line on the surface, of no symmetry where the scan need have none.
    """
    profile = config["actuator"]["profile"]
    if profile["kind"] != "measured":
        return profile_of(config)
    surface = surface_of(config)
    radius_m = min(surface.half_m)
    if profile["axisymmetric"]:
        return Sinc(wave_number_per_m=1 / radius_m)
    return StandingWave(
        wavelength_m=2 * radius_m, direction_deg=20.0, crest_m=0.1 * radius_m, surface=surface
    )


def finger_of(config: Config) -> Finger:
    """The finger pad."""
    keys = dict(config["finger"])
    contour = None
    if path := outline_path(config):
        sides_m = keys["length_x_m"], keys["length_y_m"]
        contour = read_contour(path, sides_m=sides_m, scatter_m=keys.pop("outline")["scatter_m"])
    return Finger(gap=GapShape(**keys.pop("gap")), contour=contour, **keys)


def film_of(config: Config, *, left_out: Iterable[str]) -> dict[str, Any]:
    """The study's film as far as limits of validity go, for a fit's file.

    Args:
        left_out: of the simulations, a text each; a term that is ``auto`` is included where one of
            them has it.
    """
    gas, solved = dict(config["gas"]), list(left_out)
    for term in ("inertia", "heat"):
        if gas[term] == "auto":
            gas[term] = "none" if all(term in each for each in solved) else "included"
    keys = ("length_x_m", "length_y_m", "gap")
    return {
        "gas": gas,
        "frequency_hz": config["actuator"]["frequency_hz"],
        "finger": {key: config["finger"][key] for key in keys},
    }


def symmetry_of(config: Config) -> Symmetry:
    """The finger positions that represent all; from ``actuator`` and ``finger``.

    Of a scan the settings say it: noise leaves a shape that is free no symmetry.
    """
    settings, surface = config["actuator"]["profile"], surface_of(config)
    if settings["kind"] == "measured" and not settings["axisymmetric"]:
        return no_symmetry(surface)
    return symmetry(finger_of(config), planned_profile_of(config), surface=surface)


def film_in(config: Config, *, profile: Profile | None = None) -> Film:
    """The study's gas, actuator and finger; ``profile`` stands in for its own."""
    actuator = Actuator(
        frequency_hz=config["actuator"]["frequency_hz"],
        surface=surface_of(config),
        profile=profile_of(config) if profile is None else profile,
    )
    return Film(Gas(**config["gas"]), actuator, finger_of(config))


def scenes_in(table: pd.DataFrame, config: Config, *, profile: Profile | None = None) -> Scenes:
    """The scenes of a plan on the study's film.

    Args:
        table: ``point_id``, ``h0_m``, ``hv_m`` and a position in polar or Cartesian form.
        profile: stands in for the study's own.

    Raises InputError naming the point and the factor that has no physical meaning.
    """
    names = as_in(FACTOR_COLUMNS, table)
    h0_m, hv_m, x_m, y_m = (table[name].to_numpy(dtype=float) for name in names)
    point_id = table["point_id"].astype(str).to_numpy(dtype=object)
    if POLAR[0] in names:
        radius_m, angle = x_m, np.radians(y_m)
        for row in np.flatnonzero(radius_m < 0)[:1]:
            raise InputError(
                f"point {point_id[row]}: phi_r_m = {radius_m[row]:g} must not be negative"
            )
        x_m, y_m = radius_m * np.cos(angle), radius_m * np.sin(angle)
    film = film_in(config, profile=profile)
    index = np.zeros(len(table), dtype=np.int64)
    scenes = Scenes((film,), index, h0_m, hv_m, x_m, y_m, point_id)
    check_scenes(scenes)
    return scenes


def scene_of(
    point: ScenePoint, config: Config, *, check: bool = True, profile: Profile | None = None
) -> Scene:
    """The scene of one point of a plan on the study's film, checked unless only its terms matter.

    ``profile`` stands in for the study's own.

    Raises InputError naming the point and the factor that has no physical meaning.
    """
    film = film_in(config, profile=profile)
    scene = Scene(
        point_id=point.point_id,
        h0_m=point.h0_m,
        hv_m=point.hv_m,
        x_m=point.x_m,
        y_m=point.y_m,
        gas=film.gas,
        actuator=film.actuator,
        finger=film.finger,
    )
    if check:
        check_scene(scene)
    return scene


def check_study(config: Config) -> Config:
    """Check every finger position and film of a study before anything is simulated.

    Of a scan the points: what a smooth profile through them is refused for, the rule `smooth` says.

    Raises InputError naming the section and the point that has no physical meaning.
    """
    with naming(config.path):
        finger_of(config)
        _check_scan(config)
        profile = planned_profile_of(config)
    for section, point in _extreme_points(config):
        with naming(f"{config.path}: {section}"):
            scene_of(point, config, profile=profile)
    return config


def _check_scan(config: Config) -> None:
    """Refuse a scan that cannot be read, or has points off the surface."""
    from squeezefilm.film.measured.read import read_scan
    from squeezefilm.film.measured.smooth import places_on

    path, actuator = scan_path(config), config["actuator"]
    if path is not None:
        places_on(
            read_scan(path, frequency_hz=actuator["frequency_hz"]),
            surface_of(config),
            axisymmetric=actuator["profile"]["axisymmetric"],
        )


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
