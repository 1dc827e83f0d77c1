"""Films given by their dimensionless numbers, as scenes for the solver and for other methods.

Among them the stiff and extreme ones, in groups, and which of these need not be supported.
"""

import csv
from dataclasses import replace
from itertools import product
from math import pi
from pathlib import Path
from typing import Any

from squeezefilm.film.pad import UNIFORM_GAP, GapShape, Pad, PadShape
from squeezefilm.film.profiles import (
    Formula,
    Piston,
    Profile,
    QuadratureProfile,
    Sinc,
    StandingWave,
)
from squeezefilm.film.scene import Actuator, Film, Gas, Scene
from squeezefilm.film.surfaces import Disc

PAD_LENGTH_M = 0.01
AMBIENT_PRESSURE_PA = 101_325.0
MEAN_GAP_M = 5e-6
FREQUENCY_HZ = 43_270.0
SINC_PROFILE = Sinc(wave_number_per_m=109.8)
PISTON_PROFILE = Piston()


def film_scene(
    name: str,
    epsilon: float,
    sigma: float,
    bearing: float = 0.0,
    *,
    profile: Profile = SINC_PROFILE,
    x: float = 0.0,
    y: float = 0.0,
    aspect: float = 1.0,
    knudsen: float = 0.0,
    reynolds: float = 0.0,
    thermal: bool = False,
    gap: GapShape = UNIFORM_GAP,
    shape: PadShape = "rectangle",
) -> Scene:
    """A scene with given numbers: gap, frequency and pressure of the paper, a gas to match.

    Args:
        name: what tables and figures call it.
        epsilon, sigma, bearing: excursion ratio, squeeze number, bearing number.
        profile: vibration shape of the actuator.
        x, y: the pad's centre on the actuator, in units of its side along x.
        aspect: the pad's side along y over that along x.
        knudsen: mean free path over mean gap, with first-order slip; 0 for no rarefaction.
        reynolds: modified Reynolds number, with inertia of the gas; 0 for none.
        thermal: whether the gas has thermal effects, by the Reynolds number.
        gap: the gap's shape at rest, 0 at its centre.
        shape: the pad's outline, as a scene's pad has it.
    """
    angular_frequency = 2 * pi * FREQUENCY_HZ
    viscosity = (
        sigma * AMBIENT_PRESSURE_PA * MEAN_GAP_M**2 / (12 * angular_frequency * PAD_LENGTH_M**2)
    )
    speed = bearing * AMBIENT_PRESSURE_PA * MEAN_GAP_M**2 / (6 * viscosity * PAD_LENGTH_M)
    gas = Gas(
        inertia="included" if reynolds else "none",
        thermal="included" if thermal else "none",
        viscosity_pa_s=viscosity,
        ambient_pressure_pa=AMBIENT_PRESSURE_PA,
        density_kg_per_m3=reynolds * viscosity / (angular_frequency * MEAN_GAP_M**2) or 1.2,
        mean_free_path_m=knudsen * MEAN_GAP_M or 67e-9,
        rarefaction="slip" if knudsen else "none",
    )
    actuator = Actuator(FREQUENCY_HZ, 1.0, profile=profile)
    pad = Pad(PAD_LENGTH_M, aspect * PAD_LENGTH_M, speed, gap=gap, shape=shape)
    amplitude_and_position_m = epsilon * MEAN_GAP_M, x * PAD_LENGTH_M, y * PAD_LENGTH_M
    return Film(gas, actuator, pad).scene(MEAN_GAP_M, *amplitude_and_position_m, point_id=name)


def travelling_wave_profile(wavelength: float = 2.0, direction_deg: float = 0.0) -> Profile:
    """A wave of a length in units of the pad's side."""
    wave = StandingWave(wavelength * PAD_LENGTH_M, direction_deg, crest_m=0.0)
    return QuadratureProfile(wave, replace(wave, crest_m=-wave.wavelength_m / 4))


def gap_shape(tilt_x: float = 0.0, tilt_y: float = 0.0, crown: float = 0.0) -> GapShape:
    """A gap at rest in units of h0."""
    return GapShape(tilt_x * MEAN_GAP_M, tilt_y * MEAN_GAP_M, crown * MEAN_GAP_M)


# As measurements give it: the sinc with bumps of some millimetres, a tenth of it high.
_BUMPS_FORMULA = "cos(2900*x+1100*y+1)+cos(2100*x-1700*y+2)+cos(900*x+2800*y+4)+cos(1900*x-2300*y)"
PROFILE_OF_NAME: dict[str, Profile] = {
    "": SINC_PROFILE,
    "piston": PISTON_PROFILE,
    "node": Sinc(280.0),
    "rough": Formula(f"sinc(109.8*r)*(1+0.07*({_BUMPS_FORMULA}))/1.2", surface=Disc(0.015)),
    "travelling": travelling_wave_profile(),
    "short travelling": travelling_wave_profile(0.7, 30.0),
}
# Where waves steepen so much that no grid or no step of Newton's method may be enough.
MAX_EPSILON_TIMES_REYNOLDS = 2.0
# ε and Re of films with inertia, the last beyond what is documented: such a film costs the most.
EPSILON_REYNOLDS_PAIRS = (0.1, 0.5), (0.5, 0.5), (0.9, 0.5), (0.1, 5.0), (0.5, 50.0)
SHAPE_OF_PAD_NAME: dict[str, PadShape] = {"disc": "ellipse", "square": "rectangle"}
# The plane of discs and squares with inertia and thermal effects. A square takes seconds, with a
# larger Re or ε minutes.
REYNOLDS_GRID_VALUES, SIGMA_GRID_VALUES = (0.1, 1.0, 5.0, 20.0), (1.0, 30.0, 1000.0, 1e5)
EPSILON_GRID_VALUES = (0.1, 0.5, 0.9)
# Of all cases, for a small study: every sixth, of every group some.
CASE_SAMPLE_SLICE = slice(None, None, 6)


def cases_with_groups() -> list[tuple[str, Scene]]:
    """All cases with their groups: the plane of σ and ε for two profiles, sliding, and others."""
    groups = {
        "sinc": _films_of_epsilon_and_sigma(
            "sinc", (1e-3, 1.0, 20.0, 2331.0, 1e5, 1e7), (1e-3, 0.1, 0.5, 0.9, 0.99)
        ),
        "piston": _films_of_epsilon_and_sigma(
            "piston", (1e-3, 20.0, 1e5, 1e7), (1e-3, 0.5, 0.9), profile=PISTON_PROFILE
        ),
        "sliding": listed_films("sliding"),
        "shape, gas, frequency": listed_films("shape, gas, frequency"),
        "inertia": [
            film_scene(f"inertia, Re = {re:g}, σ = {sigma:g}, ε = {eps:g}", eps, sigma, reynolds=re)
            for sigma, (eps, re) in product((1.0, 20.0, 583.0, 1e5), EPSILON_REYNOLDS_PAIRS)
        ],
        "any gap, ellipse": listed_films("any gap, ellipse"),
        "inertia and thermal effects": [
            *films_with_effects("disc"),
            *films_with_effects("square", REYNOLDS_GRID_VALUES[:2], EPSILON_GRID_VALUES[:2]),
        ],
    }
    return [(group, scene) for group, scenes in groups.items() for scene in scenes]


def listed_films(group: str) -> list[Scene]:
    """The films of a group in films.csv, whose columns are arguments of ``film_scene``."""
    text = Path(__file__).with_name("films.csv").read_text(encoding="utf-8")
    films = []
    for row in csv.DictReader(text.splitlines()):
        name, profile, shape = row.pop("name"), row.pop("profile"), row.pop("shape")
        if row.pop("group") == group:
            numbers: dict[str, Any] = {key: float(cell) for key, cell in row.items() if cell}
            numbers["thermal"] = "thermal" in numbers
            tilts_and_crown = (numbers.pop(key, 0.0) for key in ("tilt_x", "tilt_y", "crown"))
            how: dict[str, Any] = {"shape": shape} if shape else {}
            how |= {"profile": PROFILE_OF_NAME[profile], "gap": gap_shape(*tilts_and_crown)}
            films.append(film_scene(name, **numbers, **how))
    return films


def films_with_effects(
    pad: str,
    reynolds: tuple[float, ...] = REYNOLDS_GRID_VALUES,
    epsilon: tuple[float, ...] = EPSILON_GRID_VALUES,
) -> list[Scene]:
    """Films with inertia and thermal effects under a disc or a square, over Re, σ and ε."""
    return [
        film_scene(
            f"{pad}, thermal effects, Re = {re:g}, σ = {sigma:g}, ε = {eps:g}",
            *(eps, sigma),
            reynolds=re,
            thermal=True,
            shape=SHAPE_OF_PAD_NAME[pad],
        )
        for re, sigma, eps in product(reynolds, SIGMA_GRID_VALUES, epsilon)
    ]


def outside_region_reason(scene: Scene) -> str:
    """Return the reason why a film need not be solved; empty inside the documented region."""
    closure, epsilon = scene.closure(), scene.epsilon
    inert = scene.gas.inertia == "included"
    reasons = {
        "contact": closure >= 1,
        "nearer to contact than 2 % of the gap": closure > 0.98,
        "bearing number of 1000 or more": round(scene.bearing_number) >= 1e3,
        "squeeze number above 1e7": round(scene.sigma) > 1e7,
        f"waves that steepen: ε Re above {MAX_EPSILON_TIMES_REYNOLDS:g}": inert
        and waves_steepen(scene),
        "inertia nearer to contact than 20 % of the gap": inert and epsilon > 0.8,
    }
    return next((reason for reason, holds in reasons.items() if holds), "")


def waves_steepen(scene: Scene) -> bool:
    """Return whether waves in a gas with inertia steepen beyond what is documented."""
    return scene.epsilon * scene.modified_reynolds > MAX_EPSILON_TIMES_REYNOLDS * (1 + 1e-9)


def _films_of_epsilon_and_sigma(
    kind: str, sigma: tuple[float, ...], epsilon: tuple[float, ...], **numbers: Any
) -> list[Scene]:
    return [
        film_scene(f"{kind}, σ = {s:g}, ε = {eps:g}", eps, s, **numbers)
        for s, eps in product(sigma, epsilon)
    ]
