"""Films given by their dimensionless numbers, as scenes for the solver and for other methods.

Among them the stiff and extreme ones, in groups, and which of these the solver may refuse.
"""

from dataclasses import dataclass, replace
from itertools import product
from math import log10, pi
from typing import NamedTuple

import numpy as np

from squeezefilm.film.pad import Finger, GapShape
from squeezefilm.film.profiles import Formula, Piston, Profile, Quadrature, Sinc, StandingWave
from squeezefilm.film.scene import Actuator, Gas, Scene
from squeezefilm.film.surfaces import Disc
from verification.marching import FloatArray, Fold

LENGTH_M = 0.01
PRESSURE_PA = 101_325.0
H0_M = 5e-6
FREQUENCY_HZ = 43_270.0
SINC = Sinc(wave_number_per_m=109.8)
PISTON = Piston()
FLAT = GapShape()


@dataclass(frozen=True)
class Film:
    """A film of the Reynolds equation in dimensionless form.

    Attributes:
        name: what tables and figures call it.
        epsilon, sigma, bearing: excursion ratio, squeeze number, bearing number.
        profile: vibration shape of the actuator.
        x, y: the finger's centre on the actuator, in units of its side along x.
        aspect: the finger's side along y over that along x.
        knudsen: mean free path over mean gap, with first-order slip; 0 for no rarefaction.
        reynolds: modified Reynolds number, with inertia of the gas; 0 for none.
        gap: the gap's shape at rest, 0 at its centre.
        shape: the finger's outline, as a scene's finger has it.
    """

    name: str
    epsilon: float
    sigma: float
    bearing: float = 0.0
    profile: Profile = SINC
    x: float = 0.0
    y: float = 0.0
    aspect: float = 1.0
    knudsen: float = 0.0
    reynolds: float = 0.0
    gap: GapShape = FLAT
    shape: str = "rectangle"

    @property
    def scene(self) -> Scene:
        """A scene with these numbers: gap, frequency and pressure of the paper, a gas to match."""
        angular_frequency = 2 * pi * FREQUENCY_HZ
        viscosity = self.sigma * PRESSURE_PA * H0_M**2 / (12 * angular_frequency * LENGTH_M**2)
        speed = self.bearing * PRESSURE_PA * H0_M**2 / (6 * viscosity * LENGTH_M)
        density = self.reynolds * viscosity / (angular_frequency * H0_M**2)
        return Scene(
            point_id=self.name,
            h0_m=H0_M,
            hv_m=self.epsilon * H0_M,
            x_m=self.x * LENGTH_M,
            y_m=self.y * LENGTH_M,
            gas=Gas(
                inertia="included" if self.reynolds else "none",
                heat="none",
                viscosity_pa_s=viscosity,
                ambient_pressure_pa=PRESSURE_PA,
                density_kg_per_m3=density or 1.2,
                mean_free_path_m=self.knudsen * H0_M or 67e-9,
                rarefaction="slip" if self.knudsen else "none",
            ),
            actuator=Actuator(frequency_hz=FREQUENCY_HZ, surface=Disc(1.0), profile=self.profile),
            finger=Finger(
                length_x_m=LENGTH_M,
                length_y_m=self.aspect * LENGTH_M,
                speed_x_m_per_s=speed,
                gap=self.gap,
                shape=self.shape,
            ),
        )

    def amplitude(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """The profile s at x, y in [0, 1] across the finger."""
        return self.scene.amplitude(x, y)

    @property
    def fold(self) -> Fold:
        """Whether the film is even about the middle of x and of y, probed at some points."""
        nodes = np.linspace(0.03, 0.46, 7)
        x, y = np.meshgrid(nodes, 1.1 * nodes, indexing="ij")
        s = self.amplitude(x, y)
        even_x = np.allclose(self.amplitude(1 - x, y), s, rtol=0, atol=1e-13)
        even_y = np.allclose(self.amplitude(x, 1 - y), s, rtol=0, atol=1e-13)
        even_x = even_x and self.bearing == 0 and self.gap.tilt_x_m == 0
        return bool(even_x), bool(even_y and self.gap.tilt_y_m == 0)


def travelling(wavelength: float = 2.0, direction_deg: float = 0.0) -> Profile:
    """A wave of a length in units of the finger's side."""
    wave = StandingWave(wavelength * LENGTH_M, direction_deg, crest_m=0.0)
    return Quadrature(wave, replace(wave, crest_m=-wave.wavelength_m / 4))


def gap_shape(tilt_x: float = 0.0, tilt_y: float = 0.0, bulge: float = 0.0) -> GapShape:
    """A gap at rest in units of h0."""
    return GapShape(tilt_x * H0_M, tilt_y * H0_M, bulge * H0_M)


# Where waves steepen so much that no grid or no step of Newton's method may be enough.
STEEPEST = 2.0
TILTED, BULGING = gap_shape(tilt_x=0.4), gap_shape(bulge=0.3)
# Of all cases, for a small study: every sixth, of every group some.
SAMPLE = slice(None, None, 6)


class Case(NamedTuple):
    """A film in its group."""

    film: Film
    group: str


def cases() -> list[Case]:
    """All cases: the plane of σ and ε for two profiles, sliding, shapes, gases, inertia, gaps."""
    groups = {
        "sinc": _plane("sinc", (1e-3, 1.0, 20.0, 2331.0, 1e5, 1e7), (1e-3, 0.1, 0.5, 0.9, 0.99)),
        "piston": [
            replace(film, profile=PISTON)
            for film in _plane("piston", (1e-3, 20.0, 1e5, 1e7), (1e-3, 0.5, 0.9))
        ],
        "sliding": [
            Film(f"sliding, Λ = {_power(bearing)}, σ = {_power(sigma)}", 0.4, sigma, bearing)
            for bearing, sigma in (
                *((1.0, 583.0), (100.0, 1.0), (100.0, 583.0)),
                *((1e3, 583.0), (1e3, 1e5), (1e4, 583.0)),
            )
        ],
        "shape, gas, frequency": SHAPES,
        "inertia": [
            Film(f"inertia, Re = {re:g}, σ = {sigma:g}, ε = {eps:g}", eps, sigma, reynolds=re)
            for sigma, eps, re in product(
                (1.0, 20.0, 583.0, 1e5), (0.1, 0.5, 0.9), (0.5, 5.0, 50.0)
            )
        ],
        "any gap, ellipse": [
            *(
                replace(film, name=f"{kind}, σ = {sigma:g}", sigma=sigma)
                for (kind, film), sigma in product(GAPS.items(), (1.0, 20.0, 2331.0, 1e5))
                if film.shape == "rectangle" or sigma < 1e5
            ),
            *SINGLE_GAPS,
        ],
    }
    return [Case(film, group) for group, films in groups.items() for film in films]


def beyond(film: Film) -> str:
    """Why a film may be refused; empty inside the region that the solver is documented for."""
    reasons = {
        "contact": film.scene.closure() >= 1,
        "nearer to contact than 2 % of the gap": film.scene.closure() > 0.98,
        "bearing number of 1000 or more": abs(film.bearing) >= 1e3,
        "squeeze number above 1e7": film.sigma > 1e7,
        f"waves that steepen: ε Re above {STEEPEST:g}": film.epsilon * film.reynolds > STEEPEST,
        "inertia nearer to contact than 20 % of the gap": film.epsilon > 0.8 and film.reynolds > 0,
    }
    return next((reason for reason, holds in reasons.items() if holds), "")


def _plane(kind: str, sigma: tuple[float, ...], epsilon: tuple[float, ...]) -> list[Film]:
    return [
        Film(f"{kind}, σ = {_power(s)}, ε = {eps:g}", eps, s) for s, eps in product(sigma, epsilon)
    ]


def _power(value: float) -> str:
    if value == 1 or (abs(log10(value)) < 4 and value >= 0.1):
        return f"{value:g}"
    return f"1e{round(log10(value))}"


_WAVE = travelling()
# As measurements give it: the sinc with bumps of some millimetres, a tenth of it high.
_BUMPS = "cos(2900*x+1100*y+1)+cos(2100*x-1700*y+2)+cos(900*x+2800*y+4)+cos(1900*x-2300*y)"
ROUGH = Formula(f"sinc(109.8*r)*(1+0.07*({_BUMPS}))/1.2", surface=Disc(0.015))
THIN = Film("", 0.01, 20.0, profile=PISTON, aspect=20.0)
SHAPES = (
    Film("node of the profile under the finger", 0.5, 583.0, profile=Sinc(280.0)),
    Film("rough measured profile", 0.4, 583.0, profile=ROUGH),
    Film("off centre, at the rim of the disc", 0.4, 2331.0, x=0.293),
    Film("off centre, diagonal", 0.4, 2331.0, x=0.2051, y=0.2051),
    Film("off centre, small amplitude", 1e-3, 583.0, x=0.2, y=0.1),
    replace(THIN, name="very thin finger, 1 : 100", epsilon=1e-3, aspect=100.0),
    Film("very thin finger, 100 : 1", 1e-3, 2e5, profile=PISTON, aspect=0.01),
    Film("1 Hz", 0.4, 0.054),
    Film("1 GHz", 0.4, 5.4e7),
    Film("rarefied gas, Kn = 0.0134", 0.44, 1e6, knudsen=0.0134),
    Film("rarefied gas, Kn = 0.1", 0.44, 1e6, knudsen=0.1),
    Film("contact", 1.0, 583.0),
)
GAPS = {
    "travelling wave": Film("", 0.5, 583.0, profile=_WAVE),
    "short wave travelling across": Film("", 0.5, 583.0, profile=travelling(0.7, 30.0)),
    "tilted": Film("", 0.5, 583.0, gap=TILTED),
    "bulging": Film("", 0.5, 583.0, gap=BULGING),
    "hollow, tilted both ways": Film("", 0.3, 583.0, gap=gap_shape(0.3, 0.2, -0.1)),
    "ellipse": Film("", 0.5, 583.0, shape="ellipse", aspect=0.7),
}
SINGLE_GAPS = (
    Film("travelling wave, ε = 0.95", 0.95, 583.0, profile=_WAVE),
    Film("travelling wave, ε = 0.001", 1e-3, 583.0, profile=_WAVE),
    Film("travelling wave, σ = 1e7", 0.5, 1e7, profile=_WAVE),
    Film("tilted, a fifth of the gap left", 0.15, 583.0, gap=gap_shape(1.6)),
    Film("tilted, 90 % of the gap closed", 0.9 * 0.8, 583.0, profile=PISTON, gap=TILTED),
    Film("tilted at the rim of the disc", 0.4, 2331.0, x=0.2051, y=0.2051, gap=TILTED),
    Film("tilted under a travelling wave", 0.4, 2331.0, profile=_WAVE, gap=gap_shape(0.3, 0.3)),
    Film("tilted, sliding, Λ = 30", 0.4, 583.0, 30.0, gap=TILTED),
    Film("bulging, rarefied gas, Kn = 0.05", 0.4, 583.0, knudsen=0.05, gap=BULGING),
    replace(THIN, name="thin finger 1 : 20, tilted along", gap=gap_shape(tilt_y=0.4)),
    Film("travelling wave, inertia, Re = 0.5", 0.5, 583.0, profile=_WAVE, reynolds=0.5),
    Film("tilted, inertia, Re = 0.5", 0.4, 583.0, reynolds=0.5, gap=TILTED),
    Film("ellipse, tilted", 0.3, 200.0, shape="ellipse", gap=TILTED),
    Film("tilted until it touches", 0.5, 583.0, gap=gap_shape(1.7)),
)
