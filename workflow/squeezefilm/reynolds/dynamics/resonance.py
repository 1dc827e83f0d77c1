"""The vertical motion of a mass that floats on a film: its frequency and its damping.

The film's stiffness rises with the frequency, from that of slow motion, with gas that comes and
goes through the rim, to that of gas that stays; in between the gas that is pressed out damps. So
free motion exp(st) of a mass m is a root of its equation of motion with the film's stiffness at
that complex s,

    m s² + k + K(s/ω) − K(0) = 0,   s = −ζ ωₙ ± i ωₙ √(1 − ζ²),

k the stiffness of slow motion of the settled film and K that of the slow film (slow_film.py);
without inertia and heat of the gas, which matter at the vibration's frequency.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan

from squeezefilm.reynolds.dynamics.levitation import Levitation
from squeezefilm.reynolds.dynamics.response import MOST_MODULATION
from squeezefilm.reynolds.dynamics.scenes import refused, slow_film_of

# Of the slow film's settled force. Up to there the stiffness is within 1 % of the full equation's
# (on strips, σ 20–2700, ε 0.1–0.8).
MOST_ERROR = 0.2
# Imaginary part over size of a root from which on it is an oscillation, and no numerical noise.
LEAST_OSCILLATION = 1e-3
DAMPED = "no oscillation: gas that is pressed out damps the motion away (overdamped)"


@dataclass(frozen=True)
class Resonance:
    """Free vertical motion of a mass on a film.

    Attributes:
        frequency_hz: at which it oscillates as it dies away, |Im s|/2π; NaN where there is no
            oscillation or none is known.
        damping_ratio: ζ = −Re s/|s|, 1 for critical damping; NaN as the frequency.
        reason: why there is none or none is known; empty where there is one.
    """

    frequency_hz: float
    damping_ratio: float
    reason: str = ""


def resonance(found: Levitation, *, mass_kg: float) -> Resonance:
    """The slowest free oscillation, of a small motion."""
    scene = found.scene
    if not found.stable:
        return Resonance(nan, nan, "no resonance: not stable")
    settled = replace(scene, gas=replace(scene.gas, inertia="none", heat="none"))
    if reason := refused(settled):
        return _unknown(reason)
    film, error = slow_film_of(settled)
    if error > MOST_ERROR:
        return _unknown(f"the slow film's settled force is {error:.0%} off")
    unit = mass_kg * scene.actuator.angular_frequency_rad_per_s**2
    roots = film.free_motion(
        slow=found.stiffness_n_per_m / unit, scale=scene.force_scale_n / scene.h0_m / unit
    )
    oscillations = roots[roots.imag > LEAST_OSCILLATION * abs(roots)]
    if not oscillations.size:
        return Resonance(nan, nan, DAMPED)
    root = complex(min(oscillations, key=abs))
    if abs(root) > MOST_MODULATION:
        most_hz = MOST_MODULATION * scene.actuator.frequency_hz
        return _unknown(f"it is faster than {most_hz:.3g} Hz, a tenth of the vibration")
    return Resonance(root.imag * scene.actuator.frequency_hz, -root.real / abs(root))


def _unknown(reason: str) -> Resonance:
    return Resonance(nan, nan, f"resonance not known: {reason}")
