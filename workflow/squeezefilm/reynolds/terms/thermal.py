"""Thermal effects: a gas that compression warms, between walls that stay at ambient temperature.

The energy equation, weighted with the parabola that the temperature has over the gap, is one
equation for its mean rise τ, in units of the ambient temperature (lengths by the pad's length
along x, time by 1/ω, β = ((γ − 1)/γ) Pr Re, ū the velocity by the isothermal momentum equation):

    τ = τₐ − τ_b,     τₐ + (Pr Re P H²/10) ∂τₐ/∂T = (β H²/12) ∂P/∂T,     τ_b = β σ |ū|²/20

Compression warms with a lag, for the gas has to conduct; τ_b is what friction warms less than
expansion along the film cools, and is small of second order in the motion. The gap then holds
H P (1 − τ), and beside ū flows, by the gas' density and viscosity (~ temperature^κ) and, where it
has inertia, by its lighter mass and by its swelling across the gap,

    w = −ū {(6/5) τₐ − (9/14) τ_b + κ ((3/5) τₐ − (3/7) τ_b)}
        + (Re P H²/10) {(9/7) τ ∂ū/∂T + (1/7) ū ∂τ/∂T}.

First order in τ. That heat is carried along the film, and how fast w settles, is neglected: on a
strip with resolved temperature both moved the force by less than the parabola's own error.

With first-order slip the temperature jumps at the walls (Smoluchowski; full accommodation) by
j = ζ Kn/(ρH) times its slope, ζ = 2γ/((γ + 1) Pr): that makes the warming on the right larger by
1 + 6j and the lag by 1 + 4j, which is (1 + 10j + 30j²)/(1 + 6j) for a gas that conducts alone but
for 6j². The numbers in w are those of no slip.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from squeezefilm.film.scene import OperatingPoints, Scene
from squeezefilm.reynolds.terms.inertia import LAG_PER_REYNOLDS, VelocityTerm
from squeezefilm.reynolds.terms.term import AbsentTerm, NamedNumbers

# What a jump of temperature at the walls, over its slope there, adds to the warming and to its lag.
TEMPERATURE_JUMP_WARMING_FACTOR, TEMPERATURE_JUMP_LAG_FACTOR = 6.0, 4.0


def temperature_jump(scene: OperatingPoints) -> Any:
    """ζ Kn of a scene with slip, 0 without: jump of temperature at a wall over its slope there."""
    ratio, slips = scene.gas.heat_capacity_ratio, scene.gas.rarefaction != "none"
    return 2 * ratio / ((ratio + 1) * scene.gas.prandtl) * scene.knudsen * slips


class Thermal(VelocityTerm):
    label = "thermal effects"
    NAME = "thermal"
    EQUATION_NUMBER_WIDTHS: ClassVar[Mapping[str, int]] = {
        "heating": 0,
        "thermal_lag": 0,
        "viscosity_exponent": 0,
        "jump_warms": 0,
        "jump_lags": 0,
    }
    ABSENT_TERM = AbsentTerm("thermal effects", "gas.thermal does not include them", "isothermal")
    KERNEL_FILE = "terms/thermal_over_period.cl"
    KERNEL_HOOKS = ("residual", "response")
    SUPPORTS_SINGLE_PRECISION = True
    WORK_FIELD_COUNT = 8

    @classmethod
    def of(cls, scene: Scene) -> Thermal | None:
        return cls() if scene.gas.thermal == "included" else None

    def equation_numbers(self, scene: OperatingPoints) -> NamedNumbers:
        conduction = scene.gas.prandtl * scene.modified_reynolds
        adiabatic = 1 - 1 / scene.gas.heat_capacity_ratio
        jump = temperature_jump(scene)
        warms, lags = TEMPERATURE_JUMP_WARMING_FACTOR * jump, TEMPERATURE_JUMP_LAG_FACTOR * jump
        return {
            "heating": adiabatic * conduction,
            "thermal_lag": LAG_PER_REYNOLDS * conduction,
            "viscosity_exponent": scene.gas.viscosity_exponent,
            "jump_warms": warms,
            "jump_lags": lags,
            "warming_lag": LAG_PER_REYNOLDS * conduction * (1 + lags),
            "warming": adiabatic / (12 * LAG_PER_REYNOLDS) * (1 + warms) / (1 + lags),
        }

    def unsupported_on_grid_reason(self, scene: Scene) -> str:
        if scene.gas.polytropic_exponent != 1:
            return "not supported: gas.thermal with another gas.polytropic_exponent than 1"
        return super().unsupported_on_grid_reason(scene)
