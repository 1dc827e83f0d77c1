"""Gases of films: air, other gases by name and temperature, or numbers of one's own."""

from dataclasses import dataclass, replace
from functools import cache
from math import pi, sqrt
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ValidatorFunctionWrapHandler, WrapValidator

from squeezefilm.sections import (
    SECTION_CONFIG,
    BoundedNumber,
    TermInclusion,
    error_at_key,
    key_of_name,
)

MAX_VISCOSITY_DEVIATION = 0.05
"""By how much a written viscosity may differ, relative, from that of the gas that is named."""


@dataclass(frozen=True)
class Gas:
    """The film's gas; air at 20 °C where nothing is written. Numbers that are not written are those
    of `name` at `ambient_temperature`; of another gas all are to be written. The paper states none.

    The film's own type: in Python its numbers may be any, in a study they are within limits. The
    density follows the pressure as ρ ~ p^(1/n), the mean free path goes like 1/ρ, as for molecules
    of a fixed size; ``auto`` is decided before a scene is solved, and the effects that the
    equation of a scene neglects enter its error budget alone (quantities/model_error.py).

    Attributes:
        viscosity_pa_s: dynamic viscosity μ; default: that of `name`, 1.81e-5 of air at 20 °C
        ambient_pressure_pa: pressure p0 around the pad
        density_kg_per_m3: density at ambient pressure, for the inertia of the gas; default: that
            of `name` under the pressure, 1.204 of air at 20 °C and 101325 Pa
        mean_free_path_m: mean free path at ambient density, for `rarefaction` and the budget; in
            the film it varies as 1/density; default: μ √(π/(2 p0 ρ)) of kinetic theory, 64.948 nm
            of air at 20 °C and 101325 Pa
        rarefaction: `none` (viscous flow), `slip` (first order, 6 Kn H²) or `fukui-kaneko` (flow
            factor of the linearised Boltzmann equation, at any Kn, for walls that reflect
            molecules diffusely)
        slip_coefficient: slip length over the mean free path with `rarefaction: slip`: 1 is
            Maxwell's, 6 Kn H² of flow; 1.147 that of kinetic theory, 6.88 Kn H²; more where walls
            reflect molecules like mirrors
        polytropic_exponent: n of ρ ~ p^(1/n): 1 for an isothermal film, 1.4 for adiabatic air
        inertia: whether the gas has inertia: `none`, as in the paper's equation;
            `included`; or `auto`, included in a scene whose force it changes by more than
            `solver.model_tolerance`
        thermal: whether compression and friction warm the gas, between walls that stay at ambient
            temperature: `none`, as in the paper's equation; `included`, with
            `polytropic_exponent` 1; or `auto`, included in a scene whose force it changes by more
            than `solver.model_tolerance`
        prandtl: Prandtl number, viscosity over conduction of heat; default: that of `name`, 0.71 of
            air
        heat_capacity_ratio: ratio γ of the specific heats; default: that of `name`, 1.4 of air
        viscosity_exponent: κ of the viscosity's growth with temperature, T^κ; default: that of
            `name`, 0.7 of air
        name: gas whose numbers are taken where none are written
        ambient_temperature_k: temperature of `name`, such as `20 °C`; a number is in kelvin
    """

    __pydantic_config__ = SECTION_CONFIG

    viscosity_pa_s: Annotated[float, BoundedNumber("Pa s", 1e-7, 100)] = 1.81e-5
    ambient_pressure_pa: Annotated[float, BoundedNumber("Pa", 1, 1e9)] = 101325.0
    density_kg_per_m3: Annotated[float, BoundedNumber("kg/m³", 1e-6, 1e5)] = 1.204
    mean_free_path_m: Annotated[float, BoundedNumber("m", 1e-12, 1)] = 64.948e-9
    rarefaction: Literal["none", "slip", "fukui-kaneko"] = "none"
    slip_coefficient: Annotated[float, BoundedNumber("1", 0.1, 100)] = 1.0
    polytropic_exponent: Annotated[float, BoundedNumber("1", 1, 1.67)] = 1.0
    inertia: TermInclusion = "auto"
    thermal: TermInclusion = "auto"
    prandtl: Annotated[float, BoundedNumber("1", 1e-3, 1000)] = 0.71
    heat_capacity_ratio: Annotated[float, BoundedNumber("1", 1, 1.68)] = 1.4
    viscosity_exponent: Annotated[float, BoundedNumber("1", 0, 2)] = 0.7
    name: Literal["air", "nitrogen", "helium", "argon", "carbon dioxide", "hydrogen"] = "air"
    ambient_temperature_k: Annotated[float, BoundedNumber("K", 223.15, 473.15)] = 293.15


GASES_TABLE_PATH = Path(__file__).with_name("gases.csv")
"""Numbers of gases at some temperatures under the default pressure, with their sources."""


@cache
def _gases_table_rows() -> np.ndarray:
    """Return the cells of GASES_TABLE_PATH, its header first."""
    lines = GASES_TABLE_PATH.read_text(encoding="utf-8").splitlines()
    return np.array([line.split(",") for line in lines if not line.startswith("#")])


def _properties_of_named_gas(gas: Gas) -> dict[str, float]:
    """Return the numbers of a gas by its name, temperature and pressure; powers of T between rows.

    Five digits, so that they are those of a row at its own temperature.
    """
    rows, own = _gases_table_rows()[_gases_table_rows()[:, 0] == gas.name, 1:].astype(float), {}
    kelvin, *columns = np.log(rows).T
    for name, values in zip(_gases_table_rows()[0, 2:].tolist(), columns, strict=True):
        value = np.exp(np.interp(np.log(gas.ambient_temperature_k), kelvin, values))
        own[name] = float(f"{value:.5g}")
    pressure = gas.ambient_pressure_pa / Gas.ambient_pressure_pa
    own["density_kg_per_m3"] *= pressure
    return own


def _fill_gas_properties(values: Any, validated: ValidatorFunctionWrapHandler) -> Gas:
    """A gas with what is not written of it: by its name, temperature and pressure."""
    gas = validated(values)
    own, written = _properties_of_named_gas(gas), values if isinstance(values, dict) else {}
    lacking = [each for each in own if key_of_name(each) not in written]
    viscosity = own["viscosity_pa_s"]
    if (
        "viscosity" in written
        and abs(gas.viscosity_pa_s / viscosity - 1) > MAX_VISCOSITY_DEVIATION
        and lacking
    ):
        raise error_at_key(
            f"{gas.viscosity_pa_s:g} is not that of {gas.name} at {gas.ambient_temperature_k:g} K, "
            f"{viscosity:.4g}; of another gas give {', '.join(map(key_of_name, lacking))} too, "
            f"which are {gas.name}'s where they are not written",
            "viscosity",
        )
    if gas.slip_coefficient != 1 and gas.rarefaction != "slip":
        raise error_at_key(
            f"{gas.slip_coefficient:g} is read with rarefaction: slip, and not with "
            f"{gas.rarefaction}",
            "slip_coefficient",
        )
    gas = replace(gas, **{each: own[each] for each in lacking})
    if key_of_name("mean_free_path_m") in written:
        return gas
    path_m = gas.viscosity_pa_s * sqrt(pi / 2 / gas.ambient_pressure_pa / gas.density_kg_per_m3)
    return replace(gas, mean_free_path_m=float(f"{path_m:.5g}"))


GasOfStudy = Annotated[Gas, WrapValidator(_fill_gas_properties)]
