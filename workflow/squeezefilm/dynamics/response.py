"""How the mean force follows the amplitude: gain and phase, rise and release.

By the averaged film (averaged_film.py), where its settled force is good enough. Part of the force
follows at once, as ⟨1/H⟩ does; the rest comes and goes with the gas, through the rim.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, nan, pi
from typing import Any

import numpy as np
from scipy.optimize import brentq

from squeezefilm.dynamics.averaged_film import (
    POINTS,
    AveragedFilm,
    averaged_film_of,
    film_on,
    refused,
)
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import LIMITS
from squeezefilm.quantities.outputs import AROUND, STEP, quotient
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.solver import solve
from squeezefilm.solution import Solution

# Relative error of the settled force up to which the slow film's numbers are given.
SLOW_ERROR = 0.03
# What the slow film leaves out of a gain, per square of the modulation over the vibration: about
# twice what the worst of 19 random films needed (ε 0.05–0.85, σ 130–8000, aspects 0.6–2.5).
AVERAGING_ERROR = 2.0
# Modulations are slow up to this share of the vibration's frequency.
MOST_MODULATION = 0.1
# What is left of the way when a film counts as settled.
LEFT = 0.05
INSTANTS = 240
# Tolerance of the forces whose quotients are gains: their errors count fifty times in one.
GAIN_TOLERANCE = 1e-4
# Terms of the gas that the averaged film neglects.
NEGLECTED = ("inertia", "heat")
# Numbers of a response whose change by a neglected effect is said, by what their columns call them.
CHANGED = {
    "gain": "static_gain",
    "corner": "corner_hz",
    "rise": "rise_s",
    "release": "release_s",
}


@dataclass(frozen=True)
class Gains:
    """Relative change of the force per small relative change of the amplitude.

    Attributes:
        frequency_hz: of the modulation, shape (n,).
        gain: its size, 2 or a little more for a modulation that is slow enough.
        phase_deg: of the force behind the amplitude where it is negative.
        error: of ``gain``, relative, and of the phase in radians.
    """

    frequency_hz: np.ndarray
    gain: np.ndarray
    phase_deg: np.ndarray
    error: np.ndarray


@dataclass(frozen=True)
class Response:
    """How one film answers, by the slow film.

    Attributes:
        static_gain: for a modulation of no frequency.
        prompt_gain: for one too fast for the gas to leave.
        corner_hz: where what lies between them has fallen by 3 dB.
        prompt_share: of the settled force, that is there when the surface starts.
        rise_s: until the force stays within 5 % of the settled one.
        lasting_share: of the settled force, that is left when the surface stops.
        release_s: until 5 % of the settled force is left.
        error: relative, of the static gain, which is that of the settled force. Corner, shares and
            prompt gain are those of the slow equation; times are known to two periods at best.
    """

    static_gain: float
    prompt_gain: float
    corner_hz: float
    prompt_share: float
    rise_s: float
    lasting_share: float
    release_s: float
    error: float


@dataclass(frozen=True)
class Steps:
    """Mean force after the surface starts from rest, and after it stops; shapes (n,).

    By the slow film: what lies within two periods of the vibration is no more than a direction.
    """

    time_s: np.ndarray
    rising_n: np.ndarray
    falling_n: np.ndarray


def gains(scene: Scene, frequency_hz: np.ndarray) -> Gains:
    """Gain and phase of a scene's force at some modulation frequencies.

    Raises:
        InputError: for a frequency that is not slow against the vibration.
        RunError: saying why the scene is not supported.
    """
    frequency_hz = np.asarray(frequency_hz, dtype=float)
    vibration_hz = scene.actuator.frequency_hz
    most = MOST_MODULATION * vibration_hz
    if not np.all((frequency_hz > 0) & (frequency_hz <= most)):
        raise InputError(
            f"a modulation's frequency must lie above 0 and up to {most:g} Hz, a tenth of the "
            "vibration's"
        )
    film, error = _slow(scene)
    modulations = frequency_hz / vibration_hz
    found = film.response(modulations)
    return Gains(
        frequency_hz=frequency_hz,
        gain=np.abs(found),
        phase_deg=np.degrees(np.angle(found)),
        error=error + AVERAGING_ERROR * modulations**2,
    )


def response(scene: Scene) -> Response:
    """A scene's response in a few numbers.

    Raises RunError saying why the scene is not supported.
    """
    return _response(scene, *_slow(scene))


def slip_changes(scene: Scene) -> dict[str, float]:
    """Changes in % of a supported scene's response with first-order slip, by their columns.

    From the slow equation with and without slip on the coarsest grid: 0 where the scene has slip,
    NaN above the Knudsen numbers that slip of first order is meant for.
    """
    pairs = [(nan, nan)] * len(CHANGED)
    slipping = replace(scene, gas=replace(scene.gas, rarefaction="slip"))
    if not any(limit.exceeded(slipping) for limit in LIMITS if limit.symbol == "Kn"):
        both = [_response(each, *film_on(each, POINTS[0])) for each in (scene, slipping)]
        pairs = [(getattr(both[0], name), getattr(both[1], name)) for name in CHANGED.values()]
    return {
        f"slip_{what}_percent": 100 * (after / before - 1)
        for what, (before, after) in zip(CHANGED, pairs, strict=True)
    }


def steps_of(scene: Scene) -> Steps:
    """The mean force after start and stop of a scene's vibration, by the slow film.

    Raises RunError saying why the scene is not supported.
    """
    film, _ = _slow(scene)
    time, rising, falling = _steps(film)
    scale = scene.force_scale_n
    time_s = time / scene.actuator.angular_frequency_rad_per_s
    return Steps(time_s, rising * scale, falling * scale)


def _slow(scene: Scene) -> tuple[AveragedFilm, float]:
    if reason := refused(scene):
        raise RunError(f"not supported: {reason}")
    film, error = averaged_film_of(scene)
    if error > SLOW_ERROR:
        raise RunError(
            "not supported: the film is not slow against its vibration (error of the averaged "
            f"film's settled force: {100 * error:.2g} %, at most {100 * SLOW_ERROR:g} % is allowed)"
        )
    return film, error


def _response(scene: Scene, film: AveragedFilm, error: float) -> Response:
    static, prompt = film.response(np.array([0.0, inf])).real
    rate = scene.actuator.angular_frequency_rad_per_s
    time, rising, falling = _steps(film)
    settled = film.mean(film.density(film.settled(film.epsilon)), film.epsilon)
    return Response(
        static_gain=float(static),
        prompt_gain=float(prompt),
        corner_hz=_corner(film, static, prompt) * scene.actuator.frequency_hz,
        prompt_share=float(rising[0] / settled),
        rise_s=_crossing(time, np.abs(rising / settled - 1)) / rate,
        lasting_share=float(falling[0] / settled),
        release_s=_crossing(time, np.abs(falling / settled)) / rate,
        error=error,
    )


def _corner(film: AveragedFilm, static: float, prompt: float) -> float:
    """Modulation, in units of ω, at which |gain − prompt| has fallen by 3 dB."""

    def above(exponent: float) -> float:
        (gain,) = film.response(np.array([np.exp(exponent)]))
        return float(abs(gain - prompt) - abs(static - prompt) / np.sqrt(2))

    guess = np.log(2 * pi**2 / film.sigma)
    return float(np.exp(brentq(above, guess - 6, guess + 6, rtol=1e-6)))


def _steps(film: AveragedFilm) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times T and the mean overpressure in p0 after start and stop, each (n,).

    From a thousandth of the slowest mode's decay time to twenty times that.
    """
    narrow = 1 + film.films.aspect[0] ** -2
    slowest = film.sigma / (pi**2 * narrow)
    time = np.append(0.0, np.geomspace(1e-3 * slowest, 20 * slowest, INSTANTS))
    settled = film.density(film.settled(film.epsilon))
    rising = film.after_step(film.at_rest(), film.epsilon, time)
    return time, rising, film.after_step(settled, 0.0, time)


def _crossing(time: np.ndarray, left: np.ndarray) -> float:
    """The last time at which LEFT is crossed, interpolated on the logarithm of what is left."""
    outside = np.flatnonzero(left > LEFT)
    if not outside.size:
        return 0.0
    last = outside[-1]
    if last + 1 == len(time):
        return float("nan")
    ends = np.log(np.maximum(left[last : last + 2], 1e-300) / LEFT)
    share = ends[0] / (ends[0] - ends[1])
    return float(time[last] + share * (time[last + 1] - time[last]))


def slow_gains(
    scenes: Sequence[Scene], *, tolerance: float, device: Device
) -> list[tuple[float, float]]:
    """Relative change of the force per relative change of the amplitude, and its error.

    By difference quotients of forces; the scenes' terms must be decided. NaN where an amplitude
    within 2 % has no force.
    """
    factors = 1 + STEP * np.array([0, *AROUND])
    forces = solve(
        [replace(scene, hv_m=float(scene.hv_m * each)) for scene in scenes for each in factors],
        tolerance=min(tolerance, GAIN_TOLERANCE),
        device=device,
    )
    count = len(factors)
    return [_gain(forces[k * count : (k + 1) * count], each.hv_m) for k, each in enumerate(scenes)]


def _gain(solutions: Sequence[Solution], hv_m: float) -> tuple[float, float]:
    if any(each.status != "ok" for each in solutions):
        return nan, nan
    forces, errors = np.array([(each.force_n, each.force_error_n) for each in solutions]).T
    slope, error = quotient(forces[1:], errors[1:], hv_m)
    gain = -slope * hv_m / forces[0]
    return gain, abs(gain) * errors[0] / abs(forces[0]) + error * hv_m / forces[0]


def gain_changes(
    scenes: Sequence[Scene], *, tolerance: float, device: Device
) -> list[dict[str, float]]:
    """Changes in % of the gain of slow modulation with each of NEGLECTED, by their columns.

    NaN where a force is not found with it.
    """
    choices: list[dict[str, Any]] = [{}, *({name: "included"} for name in NEGLECTED)]
    without = [replace(each, gas=replace(each.gas, inertia="none", heat="none")) for each in scenes]
    found = slow_gains(
        [replace(one, gas=replace(one.gas, **choice)) for one in without for choice in choices],
        tolerance=tolerance,
        device=device,
    )
    changes = []
    for first in range(0, len(found), len(choices)):
        (base, doubt), *others = found[first : first + len(choices)]
        row = {}
        for name, (gain, error) in zip(NEGLECTED, others, strict=True):
            row[f"{name}_gain_percent"] = 100 * (gain / base - 1)
            row[f"{name}_gain_error_percent"] = 100 * (error + doubt) / base
        changes.append(row)
    return changes
