"""Films given by their dimensionless numbers, as scenes for the solver and for the yardsticks."""

from dataclasses import dataclass, replace
from math import ceil, log, log10, pi, sqrt

import numpy as np

from numerics.peers.yardstick import FloatArray, Fold
from squeezefilm.film.finger import Finger, GapShape
from squeezefilm.film.scene import Actuator, Gas, Scene
from squeezefilm.film.vibration.shapes import Piston, Profile, Sinc, TwoPhases, Vibration
from squeezefilm.film.vibration.surfaces import Disc

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
    profile: Vibration = SINC
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
                polytropic_exponent=1.0,
                prandtl=0.71,
                heat_capacity_ratio=1.4,
                viscosity_exponent=0.7,
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
        s = self.scene.parts(x, y)
        even_x = np.allclose(self.scene.parts(1 - x, y), s, rtol=0, atol=1e-13)
        even_y = np.allclose(self.scene.parts(x, 1 - y), s, rtol=0, atol=1e-13)
        even_x = even_x and self.bearing == 0 and self.gap.tilt_x_m == 0
        return bool(even_x), bool(even_y and self.gap.tilt_y_m == 0)

    @property
    def mirrored(self) -> "Film":
        """The film seen in a mirror along x."""
        profile = self.profile
        seen: Vibration
        if isinstance(profile, TwoPhases):
            seen = replace(profile, first=Mirrored(profile.first), second=Mirrored(profile.second))
        else:
            seen = Mirrored(profile)
        gap = replace(self.gap, tilt_y_m=-self.gap.tilt_y_m)
        return replace(self, y=-self.y, profile=seen, gap=gap)


@dataclass(frozen=True)
class Rough:
    """A profile as measurements give it: the sinc with bumps of some millimetres.

    Attributes:
        height: root mean square of the bumps, in units of the maximum.
        wavelength_m: shortest wavelength of the bumps.
        seed: of the random phases.
    """

    height: float
    wavelength_m: float
    seed: int = 1

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        random = np.random.default_rng(self.seed)
        waves = 24
        size = 2 * pi / self.wavelength_m * random.uniform(0.3, 1.0, waves)
        direction, phase = random.uniform(0, 2 * pi, (2, waves))
        bumps = sum(
            np.cos(k * (np.cos(d) * x_m + np.sin(d) * y_m) + f)
            for k, d, f in zip(size, direction, phase, strict=True)
        )
        smooth = SINC.amplitude(x_m=x_m, y_m=y_m)
        return np.asarray(smooth * (1 + self.height * np.sqrt(2 / waves) * bumps))


@dataclass(frozen=True)
class Mirrored:
    """A profile seen in a mirror along x."""

    profile: Profile

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return self.profile.amplitude(x_m=x_m, y_m=-y_m)


def balanced_points(film: Film, tolerance: float, *, fold: Fold) -> tuple[int, int, int]:
    """nx, ny and nt of a grid whose errors in space and in time are both about the tolerance.

    Chebyshev points resolve a layer of width 1/sqrt(sigma) with a number in proportion to
    sigma^(1/4); the harmonics of powers of 1/(1 + epsilon sin T) fall by a factor rho each. Counts
    are multiples of four, of folded sides those of one half.
    """
    rho = film.epsilon / (1 + sqrt(1 - film.epsilon**2))
    digits = -log10(tolerance)

    def points(sigma: float, folded: bool) -> int:
        nodes = 7 + 0.36 * digits * sigma**0.25
        return 4 * ceil(nodes / (8 if folded else 4))

    return (
        points(film.sigma, fold[0]),
        points(film.sigma * film.aspect**2, fold[1]),
        max(8, 4 * ceil(log(tolerance) / log(rho) / 4)),
    )
