"""One operating point of a squeeze film, and the dimensionless numbers that govern it."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, isfinite, pi, radians, sin, sqrt

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.profiles import Profile

GAPS_M = (1e-9, 1e-3)


@dataclass(frozen=True)
class Gas:
    """The film's gas.

    ``rarefaction`` is ``none`` (viscous flow), ``slip`` (first order) or ``fukui-kaneko``.
    The density follows the pressure as ρ ~ p^(1/n) with the ``polytropic_exponent`` n: 1 for an
    isothermal film, the ratio of specific heats for an adiabatic one. Density and, without
    rarefaction, mean free path only enter the regime warnings.
    """

    viscosity_pa_s: float
    ambient_pressure_pa: float
    density_kg_per_m3: float
    mean_free_path_m: float
    rarefaction: str
    polytropic_exponent: float


# Poiseuille flow of a rarefied gas over that of a viscous one, as a polynomial in 1/D with the
# inverse Knudsen number D = √π P H / (2 Kn): Fukui and Kaneko, J. Tribology 112 (1990), 78–83, the
# branch for D ≥ 5.
FUKUI_KANEKO = (1.0, 6 * 1.0162, 6 * 1.0653, -6 * 2.1354)
FUKUI_KANEKO_LEAST_D = 5.0


@dataclass(frozen=True)
class Actuator:
    """A disc that vibrates normal to itself with amplitude hv · s(x, y) at one frequency."""

    frequency_hz: float
    surface_radius_m: float
    profile: Profile

    @property
    def angular_frequency_rad_per_s(self) -> float:
        return 2 * pi * self.frequency_hz


@dataclass(frozen=True)
class Finger:
    """A rectangular pad with sides along x and y, sliding along x at a constant speed."""

    length_x_m: float
    length_y_m: float
    speed_x_m_per_s: float


@dataclass(frozen=True)
class Scene:
    """One operating point: gap, amplitude and finger position on a given actuator.

    ``h0_m`` is the mean gap, ``hv_m`` the amplitude at the profile's maximum; the finger's centre
    lies at the polar position (``phi_r_m``, ``phi_deg``) and the pad keeps its orientation.
    """

    point_id: str
    h0_m: float
    hv_m: float
    phi_r_m: float
    phi_deg: float
    gas: Gas
    actuator: Actuator
    finger: Finger

    @property
    def x_m(self) -> float:
        return self.phi_r_m * cos(radians(self.phi_deg))

    @property
    def y_m(self) -> float:
        return self.phi_r_m * sin(radians(self.phi_deg))

    @property
    def epsilon(self) -> float:
        """Excursion ratio hv/h0."""
        return self.hv_m / self.h0_m

    @property
    def sigma(self) -> float:
        """Squeeze number 12 μ ω l0² / (p0 h0²), l0 the finger's length along x (paper eq. 1)."""
        return (
            12
            * self.gas.viscosity_pa_s
            * self.actuator.angular_frequency_rad_per_s
            * self.finger.length_x_m**2
            / (self.gas.ambient_pressure_pa * self.h0_m**2)
        )

    @property
    def bearing_number(self) -> float:
        """Bearing number Λ = 6 μ U l0 / (p0 h0²) (paper eq. 1)."""
        return (
            6
            * self.gas.viscosity_pa_s
            * self.finger.speed_x_m_per_s
            * self.finger.length_x_m
            / (self.gas.ambient_pressure_pa * self.h0_m**2)
        )

    @property
    def knudsen(self) -> float:
        """Knudsen number: mean free path over mean gap, at ambient pressure."""
        return self.gas.mean_free_path_m / self.h0_m

    @property
    def inverse_knudsen(self) -> float:
        """D = √π / (2 Kn) at the mean gap and ambient pressure (Fukui and Kaneko)."""
        return sqrt(pi) / (2 * self.knudsen)

    @property
    def flow_coefficients(self) -> tuple[float, ...]:
        """Coefficients c_k of the mass flux Σ c_k H^(3−k) ρ^(1−k) ∇P, the first being 1.

        Slip of first order adds 6 Kn H² (Burgdorfer 1959).
        """
        if self.gas.rarefaction == "slip":
            return (1.0, 6 * self.knudsen)
        if self.gas.rarefaction == "fukui-kaneko":
            return tuple(c / self.inverse_knudsen**k for k, c in enumerate(FUKUI_KANEKO))
        return (1.0,)

    @property
    def modified_reynolds(self) -> float:
        """Modified Reynolds number ρ ω h0² / μ: the inertia that eq. (1) leaves out."""
        return (
            self.gas.density_kg_per_m3
            * self.actuator.angular_frequency_rad_per_s
            * self.h0_m**2
            / self.gas.viscosity_pa_s
        )

    @property
    def aspect(self) -> float:
        """Length of the finger along y over its length along x."""
        return self.finger.length_y_m / self.finger.length_x_m

    @property
    def force_scale_n(self) -> float:
        """p0 times the finger's area: the force of a mean overpressure of one atmosphere."""
        return self.gas.ambient_pressure_pa * self.finger.length_x_m * self.finger.length_y_m

    def amplitude(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Profile s at positions x, y in [0, 1] across the finger, any common shape."""
        return self.actuator.profile.amplitude(
            x_m=self.x_m + (x - 0.5) * self.finger.length_x_m,
            y_m=self.y_m + (y - 0.5) * self.finger.length_y_m,
        )


def check_scene(scene: Scene) -> None:
    """Refuse a scene that has no solution or lies off the actuator.

    Raises:
        InputError: naming the point, the factor and what is allowed.
    """
    for name in ("h0_m", "hv_m", "phi_r_m", "phi_deg"):
        if not isfinite(getattr(scene, name)):
            raise InputError(f"point {scene.point_id}: {name} is not a finite number")
    if not GAPS_M[0] <= scene.h0_m <= GAPS_M[1]:
        raise InputError(
            f"point {scene.point_id}: h0_m = {scene.h0_m:g} must lie between {GAPS_M[0]:g} and "
            f"{GAPS_M[1]:g}: thinner, there is no film of gas, thicker, it is none"
        )
    if scene.hv_m < 0:
        raise InputError(f"point {scene.point_id}: hv_m = {scene.hv_m:g} must not be negative")
    if scene.hv_m >= scene.h0_m:
        raise InputError(
            f"point {scene.point_id}: hv_m = {scene.hv_m:g} reaches h0_m = {scene.h0_m:g}: "
            "surface and finger touch; the amplitude must stay below the mean gap"
        )
    if scene.phi_r_m < 0:
        raise InputError(
            f"point {scene.point_id}: phi_r_m = {scene.phi_r_m:g} must not be negative"
        )
    corner_m = max(
        hypot(
            scene.x_m + side_x * scene.finger.length_x_m / 2,
            scene.y_m + side_y * scene.finger.length_y_m / 2,
        )
        for side_x in (-1, 1)
        for side_y in (-1, 1)
    )
    if corner_m > scene.actuator.surface_radius_m:
        raise InputError(
            f"point {scene.point_id}: at phi_r_m = {scene.phi_r_m:g}, phi_deg = {scene.phi_deg:g} "
            f"a corner of the finger lies {corner_m * 1e3:.2f} mm from the centre, off the "
            f"actuator's {scene.actuator.surface_radius_m * 1e3:.2f} mm disc"
        )


def regime_warnings(scene: Scene) -> list[str]:
    """Where the isothermal Reynolds equation of this study is stretched: inertia, rarefaction."""
    warnings = []
    if scene.modified_reynolds > 1:
        warnings.append(
            f"inertia not negligible (modified Reynolds number {scene.modified_reynolds:.2g})"
        )
    if scene.knudsen > 0.01 and scene.gas.rarefaction == "none":
        warnings.append(
            f"slip of order {6 * scene.knudsen:.0%} of the flow (Kn {scene.knudsen:.2g})"
        )
    return warnings
