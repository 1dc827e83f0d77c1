"""The vertical motion of a mass that floats on a film: its frequency and its damping.

The film's stiffness rises with the frequency, from that of slow motion, with gas that comes and
goes through the rim, to that of gas that stays; in between the gas that is pressed out damps. Over
a frequency Ω it is that of the settled film and what the slow film (slow_film.py) adds to its own
settled one; without inertia and heat of the gas, which matter at the vibration's frequency.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, nan, pi, sqrt

import numpy as np
from scipy.interpolate import PchipInterpolator

from squeezefilm.reynolds.dynamics.levitation import Levitation
from squeezefilm.reynolds.dynamics.response import MOST_MODULATION
from squeezefilm.reynolds.dynamics.scenes import refused, slow_film_of

# Frequencies at which the stiffness is found, in equal ratios.
LOOKED_AT = 40
# Of the slow film's settled force. Up to there the stiffness is within 1 % of the full equation's
# (on strips, σ 20–2700, ε 0.1–0.8).
MOST_ERROR = 0.2
MOST_DAMPING = 1 / sqrt(2)
"""Damping ratio from which on the motion of an oscillator has no resonance."""
DAMPED = "no resonance: gas that is pressed out damps the motion away"


@dataclass(frozen=True)
class Resonance:
    """Free vertical motion of a mass on a film.

    Attributes:
        frequency_hz: NaN where there is no resonance.
        damping_ratio: over critical damping, at the resonance, or at the slowest motion where there
            is none; NaN where it is not known.
        reason: that there is no resonance or none is known, and why; empty where there is one.
    """

    frequency_hz: float
    damping_ratio: float
    reason: str = ""


def resonance(found: Levitation, *, mass_kg: float) -> Resonance:
    """Of a small motion; the least frequency at which it is not damped away."""
    scene = found.scene
    if not found.stable:
        return Resonance(nan, nan, "no resonance: not stable")
    settled = replace(scene, gas=replace(scene.gas, inertia="none", heat="none"))
    if reason := refused(settled):
        return _unknown(reason)
    film, error = slow_film_of(settled)
    if error > MOST_ERROR:
        return _unknown(f"the slow film's settled force is {error:.0%} off")
    vibration = scene.actuator.angular_frequency_rad_per_s
    unit = scene.force_scale_n / scene.h0_m
    at_rest, fast = film.stiffness(np.array([0.0, inf])).real
    slowest = sqrt(found.stiffness_n_per_m / mass_kg)
    fastest = sqrt((found.stiffness_n_per_m + unit * max(fast - at_rest, 0.0)) / mass_kg)
    most = MOST_MODULATION * vibration
    too_fast = f"it is faster than {most / (2 * pi):.3g} Hz, a tenth of the vibration"
    if slowest > most:
        return _unknown(too_fast)
    rates = np.geomspace(slowest / 1.1, min(1.1 * fastest, most), LOOKED_AT)
    stiffness = found.stiffness_n_per_m + unit * (film.stiffness(rates / vibration) - at_rest)
    excess = PchipInterpolator(rates, mass_kg * rates**2 - stiffness.real)
    roots = excess.roots(extrapolate=False)
    if not roots.size:
        return _unknown(too_fast)
    ratios = PchipInterpolator(rates, stiffness.imag)(roots) / (2 * mass_kg * roots**2)
    light = np.flatnonzero(ratios < MOST_DAMPING)
    if not light.size:
        return Resonance(nan, float(ratios[0]), DAMPED)
    return Resonance(float(roots[light[0]] / (2 * pi)), float(ratios[light[0]]))


def _unknown(reason: str) -> Resonance:
    return Resonance(nan, nan, f"resonance not known: {reason}")
