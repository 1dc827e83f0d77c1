"""The gain of slow modulation, hv/F ∂F/∂hv, from forces of periodic states.

It has whatever terms the scene has, unlike the response to faster modulation (response.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import RunError
from squeezefilm.reynolds.answers.stiffness import AROUND, STEP, quotient
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.solver import solve

# Of the forces that the quotient is made of: their errors count fifty times in it.
TOLERANCE = 1e-4


@dataclass(frozen=True)
class SlowGain:
    """Relative change of the force per relative change of the amplitude, and its error."""

    gain: float
    error: float

    def __str__(self) -> str:
        return f"{self.gain:.4g} ± {self.error:.1g}"


def slow_gain(scene: Scene, *, tolerance: float, device: Device, method: str = "auto") -> SlowGain:
    """By a difference quotient of forces; the scene's terms must be decided.

    Raises RunError with the reason where an amplitude within 2 % has no force.
    """
    amplitudes_m = scene.hv_m * (1 + STEP * np.array([0, *AROUND]))
    solutions = solve(
        [replace(scene, hv_m=float(hv_m)) for hv_m in amplitudes_m],
        tolerance=min(tolerance, TOLERANCE),
        device=device,
        method=method,
    )
    if bad := next((each.status for each in solutions if each.status != "ok"), None):
        raise RunError(bad)
    forces, errors = np.array([(each.force_n, each.force_error_n) for each in solutions]).T
    slope, error = quotient(forces[1:], errors[1:], scene.hv_m)
    gain = -slope * scene.hv_m / forces[0]
    return SlowGain(gain, abs(gain) * errors[0] / abs(forces[0]) + error * scene.hv_m / forces[0])
