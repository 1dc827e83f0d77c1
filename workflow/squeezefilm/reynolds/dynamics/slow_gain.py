"""The gain of slow modulation, hv/F ∂F/∂hv, from forces of periodic states.

It has whatever terms the scene has, unlike the response to faster modulation (response.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import nan
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.answers.stiffness import AROUND, STEP, quotient
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.solver import solve

# Of the forces that the quotient is made of: their errors count fifty times in it.
TOLERANCE = 1e-4
# Terms of the gas that the averaged film neglects.
NEGLECTED = ("inertia", "heat")


@dataclass(frozen=True)
class SlowGain:
    """Relative change of the force per relative change of the amplitude, and its error; or NaN."""

    gain: float
    error: float


def slow_gains(scenes: Sequence[Scene], *, tolerance: float, device: Device) -> list[SlowGain]:
    """By difference quotients of forces; the scenes' terms must be decided.

    NaN where an amplitude within 2 % has no force.
    """
    factors = 1 + STEP * np.array([0, *AROUND])
    forces = solve(
        [replace(scene, hv_m=float(scene.hv_m * each)) for scene in scenes for each in factors],
        tolerance=min(tolerance, TOLERANCE),
        device=device,
    )
    count = len(factors)
    return [_gain(forces[k * count : (k + 1) * count], each.hv_m) for k, each in enumerate(scenes)]


def _gain(solutions: Sequence[Solution], hv_m: float) -> SlowGain:
    if any(each.status != "ok" for each in solutions):
        return SlowGain(nan, nan)
    forces, errors = np.array([(each.force_n, each.force_error_n) for each in solutions]).T
    slope, error = quotient(forces[1:], errors[1:], hv_m)
    gain = -slope * hv_m / forces[0]
    return SlowGain(gain, abs(gain) * errors[0] / abs(forces[0]) + error * hv_m / forces[0])


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
        base, *others = found[first : first + len(choices)]
        row = {}
        for name, other in zip(NEGLECTED, others, strict=True):
            row[f"{name}_gain_percent"] = 100 * (other.gain / base.gain - 1)
            row[f"{name}_gain_error_percent"] = 100 * (other.error + base.error) / base.gain
        changes.append(row)
    return changes
