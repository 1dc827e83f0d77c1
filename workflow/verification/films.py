"""Films given by their dimensionless numbers, as scenes for the solver and for other methods."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from squeezefilm.film.pad import Finger, GapShape
from squeezefilm.film.profiles import Piston, Profile, Quadrature, Sinc, StandingWave
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
