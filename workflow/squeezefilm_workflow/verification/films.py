"""Films given by their dimensionless numbers, as scenes for the solver and for other methods.

Among them the stiff and extreme ones, in groups, and which of these need not be supported.
"""

from dataclasses import replace
from itertools import product
from math import pi
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


# Where waves steepen so much that no grid or no step of Newton's method may be enough.
MAX_EPSILON_TIMES_REYNOLDS = 2.0
GAP_TILTED_IN_X = gap_shape(tilt_x=0.4)
GAP_TILTED_IN_Y = gap_shape(tilt_y=0.4)
CROWNED_GAP = gap_shape(crown=0.3)
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
        "sliding": [
            film_scene(f"sliding, Λ = {bearing:g}, σ = {sigma:g}", 0.4, sigma, bearing)
            for bearing, sigma in (
                *((1.0, 583.0), (100.0, 1.0), (100.0, 583.0)),
                *((1e3, 583.0), (1e3, 1e5), (1e4, 583.0)),
            )
        ],
        "shape, gas, frequency": FILMS_WITH_OTHER_PROFILES,
        "inertia": [
            film_scene(f"inertia, Re = {re:g}, σ = {sigma:g}, ε = {eps:g}", eps, sigma, reynolds=re)
            for sigma, (eps, re) in product((1.0, 20.0, 583.0, 1e5), EPSILON_REYNOLDS_PAIRS)
        ],
        "any gap, ellipse": [
            *(
                film_scene(f"{kind}, σ = {sigma:g}", sigma=sigma, **numbers)
                for (kind, numbers), sigma in product(
                    NONUNIFORM_GAP_ARGUMENTS.items(), (1.0, 20.0, 2331.0, 1e5)
                )
                if "shape" not in numbers or sigma < 1e5
            ),
            *NONUNIFORM_GAP_FILMS,
        ],
        "inertia and thermal effects": [
            *films_with_effects("disc"),
            *films_with_effects("square", REYNOLDS_GRID_VALUES[:2], EPSILON_GRID_VALUES[:2]),
        ],
    }
    return [(group, scene) for group, scenes in groups.items() for scene in scenes]


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


_TRAVELLING_WAVE_PROFILE = travelling_wave_profile()
# As measurements give it: the sinc with bumps of some millimetres, a tenth of it high.
_BUMPS_FORMULA = "cos(2900*x+1100*y+1)+cos(2100*x-1700*y+2)+cos(900*x+2800*y+4)+cos(1900*x-2300*y)"
ROUGH_PROFILE = Formula(f"sinc(109.8*r)*(1+0.07*({_BUMPS_FORMULA}))/1.2", surface=Disc(0.015))
FILMS_WITH_OTHER_PROFILES = (
    film_scene("node of the profile under the pad", 0.5, 583.0, profile=Sinc(280.0)),
    film_scene("rough measured profile", 0.4, 583.0, profile=ROUGH_PROFILE),
    film_scene("off centre, at the rim of the disc", 0.4, 2331.0, x=0.293),
    film_scene("off centre, diagonal", 0.4, 2331.0, x=0.2051, y=0.2051),
    film_scene("off centre, small amplitude", 1e-3, 583.0, x=0.2, y=0.1),
    film_scene("very thin pad, 1 : 100", 1e-3, 20.0, profile=PISTON_PROFILE, aspect=100.0),
    film_scene("very thin pad, 100 : 1", 1e-3, 2e5, profile=PISTON_PROFILE, aspect=0.01),
    film_scene("1 Hz", 0.4, 0.054),
    film_scene("1 GHz", 0.4, 5.4e7),
    film_scene("rarefied gas, Kn = 0.0134", 0.44, 1e6, knudsen=0.0134),
    film_scene("rarefied gas, Kn = 0.1", 0.44, 1e6, knudsen=0.1),
    film_scene("contact", 1.0, 583.0),
)
NONUNIFORM_GAP_ARGUMENTS: dict[str, dict[str, Any]] = {
    "travelling wave": {"epsilon": 0.5, "profile": _TRAVELLING_WAVE_PROFILE},
    "short wave travelling across": {"epsilon": 0.5, "profile": travelling_wave_profile(0.7, 30.0)},
    "tilted": {"epsilon": 0.5, "gap": GAP_TILTED_IN_X},
    "bulging": {"epsilon": 0.5, "gap": CROWNED_GAP},
    "hollow, tilted both ways": {"epsilon": 0.3, "gap": gap_shape(0.3, 0.2, -0.1)},
    "ellipse": {"epsilon": 0.5, "shape": "ellipse", "aspect": 0.7},
}
NONUNIFORM_GAP_FILMS = (
    film_scene("travelling wave, ε = 0.95", 0.95, 583.0, profile=_TRAVELLING_WAVE_PROFILE),
    film_scene("travelling wave, ε = 0.001", 1e-3, 583.0, profile=_TRAVELLING_WAVE_PROFILE),
    film_scene("travelling wave, σ = 1e7", 0.5, 1e7, profile=_TRAVELLING_WAVE_PROFILE),
    film_scene("tilted, a fifth of the gap left", 0.15, 583.0, gap=gap_shape(1.6)),
    film_scene(
        "tilted, 90 % of the gap closed",
        0.9 * 0.8,
        583.0,
        profile=PISTON_PROFILE,
        gap=GAP_TILTED_IN_X,
    ),
    film_scene(
        "tilted at the rim of the disc", 0.4, 2331.0, x=0.2051, y=0.2051, gap=GAP_TILTED_IN_X
    ),
    film_scene(
        "tilted under a travelling wave",
        0.4,
        2331.0,
        profile=_TRAVELLING_WAVE_PROFILE,
        gap=gap_shape(0.3, 0.3),
    ),
    film_scene("tilted, sliding, Λ = 30", 0.4, 583.0, 30.0, gap=GAP_TILTED_IN_X),
    film_scene("bulging, rarefied gas, Kn = 0.05", 0.4, 583.0, knudsen=0.05, gap=CROWNED_GAP),
    film_scene(
        "thin pad 1 : 20, tilted along",
        0.01,
        20.0,
        profile=PISTON_PROFILE,
        aspect=20.0,
        gap=GAP_TILTED_IN_Y,
    ),
    film_scene(
        "travelling wave, inertia, Re = 0.5",
        0.5,
        583.0,
        profile=_TRAVELLING_WAVE_PROFILE,
        reynolds=0.5,
    ),
    film_scene("tilted, inertia, Re = 0.5", 0.4, 583.0, reynolds=0.5, gap=GAP_TILTED_IN_X),
    film_scene("ellipse, tilted", 0.3, 200.0, shape="ellipse", gap=GAP_TILTED_IN_X),
    film_scene("tilted until it touches", 0.5, 583.0, gap=gap_shape(1.7)),
)
