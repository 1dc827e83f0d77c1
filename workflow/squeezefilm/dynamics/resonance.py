"""Free vertical motion of a part that floats on a film: resonance and damping."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import inf, nan, sqrt
from typing import Any, NamedTuple

import numpy as np

from squeezefilm.dynamics.averaged_film import (
    GRID_POINT_COUNTS,
    PeriodAveragedFilm,
    averaged_film_on_grid,
    best_averaged_film,
    unsupported_reason,
)
from squeezefilm.dynamics.levitation import Levitation
from squeezefilm.film.scene import Scene
from squeezefilm.formatting import percent_text
from squeezefilm.reynolds.terms.inertia import LAG_PER_REYNOLDS
from squeezefilm.units import round_up_error

# Of the averaged film's settled force. Up to there the stiffness is within 1 % of the full
# equation's (on strips, σ 20–2700, ε 0.1–0.8).
MAX_AVERAGED_FORCE_ERROR = 0.2
# Free oscillations are given up to this share of the vibration's frequency: on discs (σ 60–3000, ε
# 0.05–0.8) stiffness there was within 1.5 % of the full equation's.
MAX_RESONANCE_FREQUENCY_RATIO = 0.3
# Error of the averaged film's stiffness in p0 over ε², |s|/ω and the edge layer's thickness: twice
# what the worst of those discs needed up to there.
AVERAGED_STIFFNESS_ERROR_FACTOR = 2.0
# The same by inertia of the vibrating gas, over ε², the layer's thickness and Re/10: about twice
# what discs needed (Re 1–7, σ 300–2000, ε 0.15–0.3; tests/numerics/ring_down.py).
INERTIA_STIFFNESS_ERROR_FACTOR = 6.0
# Excursion ratio that stands for none, and the steps to a root of the equation of motion.
NEARLY_ZERO_EPSILON = 1e-6
FIRST_ROOT_STEP, MOTION_ROOT_TOLERANCE = 1e-3, 1e-6
# Relative change of that root from one grid to the next: what is fine, and what is no answer.
ROOT_GRID_TOLERANCE, MAX_ROOT_GRID_ERROR = 1e-3, 0.1
# Imaginary part over size of a root from which on it is an oscillation, and no numerical noise.
MIN_IMAGINARY_FRACTION = 1e-3
MAX_ROOT_STEPS = 40
OVERDAMPED_STATUS = "no oscillation: gas that is pressed out damps the motion away (overdamped)"
CREEP_NOTE = "the gap also creeps back without oscillation (time constant about {:.2g} ms)"
NEARLY_CRITICAL_REASON = "the damping is nearly critical: the error decides whether it oscillates"


class Resonance(NamedTuple):
    """Free vertical motion of a mass on a film.

    Attributes:
        frequency_hz: at which it oscillates as it dies away, |Im λ|/2π; NaN where there is no
            oscillation or none is known.
        frequency_error_hz: by the averaged film, at the gap given.
        damping_ratio: ζ = −Re λ/|λ|, 1 for critical damping; NaN as the frequency.
        damping_ratio_error: likewise.
        reason: why there is none, none is known, or no more than a bound; where there is one, a
            motion that dies away more slowly, or empty.
    """

    frequency_hz: float = nan
    frequency_error_hz: float = nan
    damping_ratio: float = nan
    damping_ratio_error: float = nan
    reason: str = ""


def resonance(levitation: Levitation, *, mass_kg: float) -> Resonance:
    """The slowest free oscillation of a mass that floats, vertically, of a small motion.

    The film's stiffness rises with the frequency, from that of slow motion, with gas that comes and
    goes through the edge, to that of gas that stays; in between the gas that is pressed out damps.
    So free motion exp(λt) of a mass m is a root of its equation of motion with the film's stiffness
    at that complex λ,

        m λ² + k + K(λ/ω) − K(0) = 0,   λ = −ζ ωₙ ± i ωₙ √(1 − ζ²),

    k the stiffness of slow motion of the settled film and K that of the averaged film
    (averaged_film.py); with the lag of the gas by inertia where the film has it. Thermal effects,
    and inertia of the gas that the vibration moves, are in the errors.
    """
    scene = levitation.scene
    if not levitation.is_stable:
        return Resonance(reason="no resonance: not stable")
    settled = scene.viscous()
    if reason := unsupported_reason(settled):
        return _unknown_resonance(reason)
    film, error = best_averaged_film(settled)
    if error > MAX_AVERAGED_FORCE_ERROR:
        by = percent_text(100 * error, sign="")
        return _unknown_resonance(f"the averaged film's settled force is in error by {by}")
    unit = mass_kg * scene.actuator.angular_frequency_rad_per_s**2
    slow, scale = levitation.stiffness_n_per_m / unit, scene.force_scale_n / scene.h0_m / unit
    lag = LAG_PER_REYNOLDS * scene.modified_reynolds * (scene.gas.inertia == "included")
    slow_error = levitation.stiffness_error_n_per_m / unit
    # The layer of gas that the motion moves at the edge is thinner than a settled film needs.
    finer = GRID_POINT_COUNTS[GRID_POINT_COUNTS.index(film.grid.points) + 1 :]
    finer = finer or GRID_POINT_COUNTS[-2:-1]
    exponents = film.free_motion_exponents(slow=slow, scale=scale)
    oscillations = _oscillations(exponents)
    if not oscillations.size:
        film, _ = averaged_film_on_grid(settled, finer[0])
        near = _nearby_stiffnesses(film, scene, lag, slow=slow, slow_error=slow_error, scale=scale)
        if any(
            _oscillations(film.free_motion_exponents(slow=k, scale=gas)).size for k, gas in near
        ):
            return _unknown_resonance(NEARLY_CRITICAL_REASON)
        return Resonance(reason=OVERDAMPED_STATUS)
    motion = {"slow": slow, "scale": scale, "lag": lag}
    root, slope = _motion_root_and_slope(film, complex(min(oscillations, key=abs)), **motion)
    moved = inf
    for points in finer:
        film, _ = averaged_film_on_grid(settled, points)
        previous, (root, slope) = root, _motion_root_and_slope(film, root, **motion)
        moved = abs(root - previous)
        if not moved > ROOT_GRID_TOLERANCE * abs(root):
            break
    if not moved <= MAX_ROOT_GRID_ERROR * abs(root):
        return _unknown_resonance("no root of the equation of motion was found")
    if abs(root) > MAX_RESONANCE_FREQUENCY_RATIO:
        most_hz = MAX_RESONANCE_FREQUENCY_RATIO * scene.actuator.frequency_hz
        return _unknown_resonance(
            f"it is faster than {most_hz:.3g} Hz, {MAX_RESONANCE_FREQUENCY_RATIO:g} of the "
            f"vibration's frequency"
        )
    error = scale * _stiffness_error(film, scene, root, lag, slow / scale) + slow_error
    moved += error / abs(slope)
    known = Resonance(
        frequency_hz=abs(root.imag) * scene.actuator.frequency_hz,
        frequency_error_hz=moved * scene.actuator.frequency_hz,
        damping_ratio=-root.real / abs(root),
        damping_ratio_error=moved / abs(root),
    )
    if round_up_error(known.frequency_error_hz) < known.frequency_hz:
        slowest = exponents.real.max()
        if root.real / 2 < slowest < 0:
            rate_per_s = -slowest * scene.actuator.angular_frequency_rad_per_s
            return known._replace(reason=CREEP_NOTE.format(1e3 / rate_per_s))
        return known
    if known.damping_ratio_error >= max(known.damping_ratio, 1 - known.damping_ratio):
        # An oscillation has a damping ratio from 0 to 1: nothing is known of it.
        known = known._replace(damping_ratio=nan, damping_ratio_error=nan)
    return known._replace(reason="resonance not known: its error is as large as its value")


def _oscillations(exponents: np.ndarray) -> np.ndarray:
    """The exponents of free motion that oscillate, without the gas' inertia; none if overdamped."""
    return exponents[exponents.imag > MIN_IMAGINARY_FRACTION * abs(exponents)]


def _nearby_stiffnesses(
    film: PeriodAveragedFilm,
    scene: Scene,
    lag: float,
    *,
    slow: float,
    slow_error: float,
    scale: float,
) -> list[tuple[float, float]]:
    """Extremes of a film's stiffnesses, ``slow`` and ``scale``, within their errors.

    The relative error of K(s) − K(0) is that at the fastest rate s that the mass may have; the lag
    by inertia changes it by as much as the gas moves less.
    """
    at_rest, at_once = film.stiffness(np.array([0.0, inf])).real
    rate = min(sqrt(slow + scale * (at_once - at_rest)), MAX_RESONANCE_FREQUENCY_RATIO)
    error = _stiffness_error(film, scene, 1j * rate, lag, slow / scale)
    rise = abs(film.stiffness(np.array([rate]))[0] - at_rest)
    factors = 1 + (error / rise + lag * rate) * np.array([-1, 0, 1])
    slows = slow + slow_error * np.array([-1, 0, 1])
    return list(product(slows.tolist(), (scale * factors).tolist()))


def _motion_root_and_slope(
    film: PeriodAveragedFilm, start: complex, *, slow: float, scale: float, lag: float
) -> tuple[complex, complex]:
    """A root of the equation of motion near ``start``, and the equation's slope; NaN for none.

    By the secant method; numbers as of ``AveragedFilm.free_motion_exponents``.
    """
    (at_rest,) = film.stiffness(np.zeros(1))

    def motion_residual(s: complex) -> complex:
        (stiffness,) = film.stiffness(np.array([s / 1j]), lag)
        return complex(s**2 + slow + scale * (stiffness - at_rest))

    previous, root = start * (1 + FIRST_ROOT_STEP), start
    before = motion_residual(previous)
    for _ in range(MAX_ROOT_STEPS):
        left = motion_residual(root)
        slope = (left - before) / (root - previous)
        previous, before, root = root, left, root - left / slope
        if abs(root - previous) <= MOTION_ROOT_TOLERANCE * abs(root):
            return root, slope
    return complex(nan), complex(nan)


def stiffness_averaging_error(epsilon: float, rate: Any, layer_thickness: float) -> Any:
    """Error of the averaged film's K(s) − K(0), in units of p0, at a rate |s|/ω."""
    return AVERAGED_STIFFNESS_ERROR_FACTOR * epsilon**2 * layer_thickness * rate


def _stiffness_error(
    film: PeriodAveragedFilm, scene: Scene, root: complex, lag: float, slow: float
) -> float:
    """Error of K(s) − K(0) in units of p0, at s in units of ω.

    Args:
        film: without the gas' inertia.
        slow: stiffness of slow motion.
    """
    rates = np.array([0.0, root / 1j])
    rest = replace(film, epsilon=NEARLY_ZERO_EPSILON)
    stiffness, by_motion = film.stiffness(rates, lag), rest.stiffness(rates, lag)
    excursion = film.epsilon * float(np.abs(film.grid.s).max())
    averaging = stiffness_averaging_error(excursion, abs(root), film.layer_thickness)
    # What the vibration adds is in error by about as much as it is in slow motion, and inertia of
    # the gas that it moves changes the layer at the edge.
    by_vibration = abs(np.diff(stiffness - by_motion)[0])
    vibration = abs(slow / stiffness[0] - 1) * by_vibration
    vibration += INERTIA_STIFFNESS_ERROR_FACTOR * excursion**2 * film.layer_thickness * lag
    # The gas is up to so much denser where it keeps its temperature (mean over the gap).
    gas = scene.gas
    heated = gas.prandtl * scene.modified_reynolds * abs(root) / 12
    heat = (1 - 1 / gas.heat_capacity_ratio) * heated * abs(stiffness[1])
    return float(averaging + vibration + heat)


def _unknown_resonance(reason: str) -> Resonance:
    return Resonance(reason=f"resonance not known: {reason}")
