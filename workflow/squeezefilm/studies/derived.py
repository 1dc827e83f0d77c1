"""What of a study follows from the rest where it is not written: control plans, positions, models.

The schema has the defaults that are the same for every study; ``derived`` there says in words what
is done here.
"""

from __future__ import annotations

from math import cos, floor, hypot, log10, radians, sin
from typing import Any

from squeezefilm.io.errors import InputError

AIR_PA_S, AIR_PA = 1.81e-5, 101325.0
AIR = {
    "density_kg_per_m3": 1.204,
    "mean_free_path_m": 67e-9,
    "prandtl": 0.71,
    "heat_capacity_ratio": 1.4,
    "viscosity_exponent": 0.7,
}
"""At 20 °C, of that viscosity and under that pressure."""
LIKE_AIR = 0.05
"""By how much the viscosity of air may differ, relative, that is not quite so warm."""
FACTORS = ("h0_m", "hv_m")
ENDS = ("start", "stop")
FINER, MOST_LEVELS = 2, 1000
"""The error map's levels over the screen's: they share no points but the corners."""
SAME = 1e-9
DIRECTIONS_DEG = (0, 22.5, 45)
POSITIONS = 25
"""Of the four-factor plan, where they are to fill the reachable space."""
FARTHER = 1.1
"""An amplitude beyond the screen at which its models are tried, over the screen's largest."""
FORMULAS = {
    "comparison": (["two_factor", "polynomial_3"], ["four_factor", "polynomial_5"]),
    "refine": (["polynomial_3"], ["polynomial_5"]),
}
PHYSICS = {
    "comparison": (["limit", "limit_1"], ["limit", "limit_1", "limit_2"]),
    "refine": (["limit_1"], ["limit_2"]),
}
"""Models for a finger at the centre and anywhere, by section; physics where its limit is known."""


def with_derived(values: dict[str, Any]) -> dict[str, Any]:
    """The whole study: valid values, all other defaults in them (``schema.filled``).

    Raises InputError naming the key that nothing reasonable follows for.
    """
    values["gas"] = whole_gas(values["gas"])
    screen, control, wanted = values["screen"], values["error_map"], values["extrapolation"]
    for factor in FACTORS:
        levels = {name: screen[factor][name] for name in ENDS}
        levels["levels"] = min(FINER * screen[factor]["levels"], MOST_LEVELS)
        control[factor] = levels | control.get(factor, {})
    _other_points(screen, control)
    wanted.setdefault("h0_m", screen["h0_m"]["start"])
    if "hv_m" not in wanted:
        farthest = float(f"{FARTHER * screen['hv_m']['stop']:.12g}")
        contact = farthest >= wanted["h0_m"]
        wanted["hv_m"] = screen["hv_m"]["stop"] if contact else farthest
    if not (values["paper"] or values["positions"]):
        values["positions"]["points"] = POSITIONS
    _place(values["positions"], values["actuator"], values["finger"])
    known = _limit_is_known(values)
    for place, space in enumerate(("two_factor", "four_factor")):
        formulas, physics = FORMULAS["comparison"][place], PHYSICS["comparison"][place]
        values["comparison"].setdefault(space, formulas + physics * known)
        best = (PHYSICS if known else FORMULAS)["refine"][place]
        values["refine"].setdefault(space, list(best))
    return values


def whole_gas(gas: dict[str, Any]) -> dict[str, Any]:
    """A gas with what is not written of it: that of air, whose density goes with the pressure.

    Raises InputError for a viscosity that is not air's where something of it is not written, and
    for a coefficient of slip where there is none.
    """
    density = gas["ambient_pressure_pa"] / AIR_PA
    air = AIR | {
        "density_kg_per_m3": AIR["density_kg_per_m3"] * density,
        "mean_free_path_m": AIR["mean_free_path_m"] / density,
    }
    lacking = [name for name in air if name not in gas]
    viscosity_pa_s = gas["viscosity_pa_s"]
    if lacking and abs(viscosity_pa_s / AIR_PA_S - 1) > LIKE_AIR:
        raise InputError(
            f"gas: viscosity_pa_s {viscosity_pa_s:g} is not that of air at 20 °C, {AIR_PA_S:g}; of "
            f"another gas give {', '.join(lacking)} too, which are air's where they are not written"
        )
    if gas["slip_coefficient"] != 1 and gas["rarefaction"] != "slip":
        raise InputError(
            f"gas: slip_coefficient {gas['slip_coefficient']:g} is read with rarefaction: slip, "
            f"and not with {gas['rarefaction']}"
        )
    return gas | {name: air[name] for name in lacking}


def _other_points(screen: dict[str, Any], control: dict[str, Any]) -> None:
    """Refuse an error map all of whose points the screen has: no model could be judged by it."""

    def levels(plan: dict[str, Any], factor: str) -> list[float]:
        start, stop = (plan[factor][name] for name in ENDS)
        steps = max(plan[factor]["levels"] - 1, 1)
        return [start + (stop - start) * step / steps for step in range(plan[factor]["levels"])]

    for factor in FACTORS:
        fitted = levels(screen, factor)
        for own in levels(control, factor):
            if min(abs(own - its) for its in fitted) > SAME * abs(own):
                return
    raise InputError(
        "error_map: all its points are the screen's, and no model can be judged by points that it "
        "was fitted to; give other levels, or leave error_map out to have twice the screen's"
    )


def _place(positions: dict[str, Any], actuator: dict[str, Any], finger: dict[str, Any]) -> None:
    """Positions in the form of the surface: half of the way that the pad may go, and all of it."""
    half_x, half_y = finger["length_x_m"] / 2, finger["length_y_m"] / 2
    if "surface" not in actuator:
        reach = max(half_x, half_y) if finger["shape"] == "ellipse" else hypot(half_x, half_y)
        positions.setdefault("phi_deg", list(DIRECTIONS_DEG))
        if "phi_r_m" not in positions and "surface_radius_m" in actuator:
            room = _room("surface_radius_m", actuator["surface_radius_m"], reach, "phi_r_m")
            positions["phi_r_m"] = [_cut(room / 2), _cut(room)]
        return
    angle = radians(finger["rotation_deg"])
    c, s = abs(cos(angle)), abs(sin(angle))
    if finger["shape"] == "ellipse":
        reach_x, reach_y = hypot(c * half_x, s * half_y), hypot(s * half_x, c * half_y)
    else:
        reach_x, reach_y = c * half_x + s * half_y, s * half_x + c * half_y
    for axis, reach in (("x", reach_x), ("y", reach_y)):
        if f"{axis}_m" not in positions:
            key = f"length_{axis}_m"
            room = _room(f"surface.{key}", actuator["surface"][key] / 2, reach, f"{axis}_m")
            positions[f"{axis}_m"] = [0.0, _cut(room / 2), _cut(room)]


def _room(key: str, half_m: float, reach_m: float, name: str) -> float:
    """How far the pad may go one way."""
    if half_m - reach_m <= 1e-6 * reach_m:
        raise InputError(
            f"positions.{name}: the pad reaches {reach_m * 1e3:.4g} mm from its centre and the "
            f"surface (actuator.{key}) {half_m * 1e3:.4g} mm: there is no room to move the pad, as "
            f"the four-factor plan does; make one of them fit, or write positions.{name}"
        )
    return half_m - reach_m


def _cut(value: float) -> float:
    """A little less than the value, in three digits."""
    step = 10.0 ** (floor(log10(value)) - 2)
    return float(f"{floor(value * (1 - 1e-9) / step) * step:.3g}")


def _limit_is_known(values: dict[str, Any]) -> bool:
    """Whether the physics limit was derived for such a pad and gas (reynolds/asymptotics)."""
    gas, finger, profile = values["gas"], values["finger"], values["actuator"]["profile"]
    one_phase = profile["kind"] != "travelling-wave" and profile.get("quadrature", "0") == "0"
    return (
        finger["shape"] == "rectangle"
        and finger["speed_x_m_per_s"] == 0
        and not any(finger["gap"].values())
        and (one_phase or gas["inertia"] == "none")
        and gas["rarefaction"] == "none"
        and gas["polytropic_exponent"] == 1
    )
