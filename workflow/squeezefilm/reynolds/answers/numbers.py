"""From a film by two resolutions to its answers, each with an error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from squeezefilm.io.solution import Outputs
from squeezefilm.reynolds.answers.samples import Sample
from squeezefilm.reynolds.answers.weights import FORCE, GUARD, varies, weights_of
from squeezefilm.reynolds.error_estimate import ROUND_OFF

# No answer changes less than this share of the largest change among those alike, each over its
# size: it may agree by chance, or be small because its parts cancel.
SHARE_OF_OTHERS = 0.3
AT_REST = "the surface is at rest"
TWO_PHASES = "stiffness and damping are of a surface that moves in one phase"
INERTIA = "the shear at a wall is not derived with inertia"
RAREFIED = "the shear of a sliding wall is not derived with fukui-kaneko"


@dataclass(frozen=True)
class Answered:
    """Answers of one film, and whether those alike hold the tolerance together."""

    outputs: Outputs
    holds: bool


def answered(
    before: Sample, film: Sample, *, factor: float, left: float, tolerance: float
) -> Answered:
    """All answers that follow from a state.

    Args:
        before: the same film by a coarser resolution.
        factor: what is left after a change, in units of it.
        left: what else the pressure may be off by, in units of the ambient one.
    """
    left += ROUND_OFF * max(film.largest, -film.least)
    value, error, holds = _means(before, film, factor=factor, left=left, tolerance=tolerance)
    refused: dict[str, str] = {}
    _add_extremes(before, film, value, error, factor=factor, left=left)
    _add_centre(value, error)
    _add_stiffness(film, value, error, refused)
    _add_sliding(before, film, value, error, refused, factor=factor)
    if film.scene.gas.inertia == "included":
        refused["thrust"] = INERTIA
    return Answered(Outputs(value=value, error=error, refused=refused), holds)


def _means(
    before: Sample, film: Sample, *, factor: float, left: float, tolerance: float
) -> tuple[dict[str, float], dict[str, float], bool]:
    """The answers that are means of the pressure with a weight, their errors, and if these hold."""
    coarse, fine = weights_of(before), weights_of(film)
    value = {name: film.mean(weight) for name, weight in fine.items()}
    size = {name: film.size(weight) for name, weight in fine.items()}
    error, holds = {}, True
    for first_harmonics in (False, True):
        # Those that ask for harmonics are of first order in the amplitude, the others of second.
        alike = [n for n, weight in fine.items() if varies(weight) == first_harmonics and size[n]]
        change = {n: abs(value[n] - before.mean(coarse[n])) / size[n] for n in alike}
        most = max(change.values(), default=0.0)
        scale = max((abs(value[n]) / size[n] for n in alike), default=0.0)
        holds &= factor * most + left <= tolerance * scale or most == 0
        for n in alike:
            error[n] = size[n] * (factor * max(change[n], SHARE_OF_OTHERS * most) + left)
    shown = [name for name in value if not name.startswith(GUARD)]
    return {n: value[n] for n in shown}, {n: error.get(n, 0.0) for n in shown}, holds


def _add_extremes(
    before: Sample,
    film: Sample,
    value: dict[str, float],
    error: dict[str, float],
    *,
    factor: float,
    left: float,
) -> None:
    ambient = film.scene.gas.ambient_pressure_pa
    pairs = {"largest": (before.largest, film.largest), "least": (before.least, film.least)}
    change = max(abs(coarse - fine) for coarse, fine in pairs.values())
    for name, (_, found) in pairs.items():
        value[f"{name}_overpressure"] = ambient * found
        error[f"{name}_overpressure"] = ambient * (factor * change + left)


def _add_centre(value: dict[str, float], error: dict[str, float]) -> None:
    """Where the mean force acts; nowhere to be told without a force."""
    force, doubt = value[FORCE], error[FORCE]
    for name, moment, sign in (("centre_x", "moment_y", -1), ("centre_y", "moment_x", 1)):
        if abs(force) > 2 * doubt:
            value[name] = sign * value[moment] / force
            error[name] = (error[moment] + abs(value[name]) * doubt) / (abs(force) - doubt)


def _add_stiffness(
    film: Sample, value: dict[str, float], error: dict[str, float], refused: dict[str, str]
) -> None:
    """Force in phase with the motion of the gap and with its speed, over them."""
    scene = film.scene
    _, _, cosine = film.gap
    if scene.hv_m == 0:
        refused["harmonics"] = AT_REST
    elif np.abs(cosine).max() > ROUND_OFF * scene.epsilon:
        refused["harmonics"] = TWO_PHASES
    else:
        speed = scene.hv_m * scene.actuator.angular_frequency_rad_per_s
        for name, part, per in (
            ("film_stiffness", "force_sin", scene.hv_m),
            ("film_damping", "force_cos", speed),
        ):
            value[name], error[name] = -value[part] / per, error[part] / per


def _add_sliding(
    before: Sample,
    film: Sample,
    value: dict[str, float],
    error: dict[str, float],
    refused: dict[str, str],
    *,
    factor: float,
) -> None:
    """The shear that a sliding surface makes by itself, which the whole thrust has too."""
    scene = film.scene
    value["sliding_friction"] = error["sliding_friction"] = 0.0
    if scene.bearing_number == 0:
        return
    if scene.gas.rarefaction == "fukui-kaneko":
        refused["thrust"] = RAREFIED
        for name in ("sliding_friction", "thrust_x", "thrust_y"):
            value.pop(name), error.pop(name)
        return
    coarse, fine = _couette(before), _couette(film)
    doubt = factor * abs(fine - coarse) + ROUND_OFF * abs(fine)
    value["sliding_friction"], error["sliding_friction"] = fine, doubt
    for name, share in zip(("thrust_x", "thrust_y"), scene.finger.turned(1.0, 0.0), strict=True):
        value[name] += share * fine
        error[name] += abs(share) * doubt


def _couette(film: Sample) -> float:
    """μ U ⟨1/(h + 2λ)⟩ times the area: of a wall that drags the gas, with slip at both walls."""
    scene = film.scene
    gap = scene.gap(film.x, film.y, film.phases)
    if scene.gas.rarefaction == "slip":
        density = (1 + film.overpressure) ** (1 / scene.gas.polytropic_exponent)
        gap = gap + 2 * scene.knudsen / density
    shear = scene.gas.viscosity_pa_s * scene.finger.speed_x_m_per_s / scene.h0_m
    return float(shear * scene.finger.area_m2 * (film.weights @ (1 / gap)).mean())
