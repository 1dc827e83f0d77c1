"""The gap at which a film carries a load, and the film as a spring there.

The mean force falls as the gap grows: where it equals the load the part floats. Coming down from
above it settles at the widest such gap. Stiffness is that of slow motion, −∂F/∂h0 with the
amplitude of the surface kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import isfinite, sqrt

import numpy as np

from squeezefilm.film.existence import GAPS_M
from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.reynolds.answers.stiffness import AROUND, STEP, quotient
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.effects.automatic import decided
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.terms import notes_of

# Gaps that are looked at first, from where the surface nearly touches: hv over them, in equal
# ratios.
CLOSEST, FARTHEST, LOOKED_AT = 0.97, 1e-3, 48
LOOK_TOLERANCE = 1e-2
MOST_STEPS = 40


@dataclass(frozen=True)
class Levitation:
    """A part at rest on a film.

    Attributes:
        scene: the film at the gap found.
        force_n, force_error_n: its mean force, the load to its error.
        h0_error_m: of the gap, from the force's error and the stiffness.
        stiffness_n_per_m, stiffness_error_n_per_m: −∂F/∂h0 for slow motion.
        others_m: further gaps at which the force equals the load, rough, rising.
    """

    scene: Scene
    force_n: float
    force_error_n: float
    h0_error_m: float
    stiffness_n_per_m: float
    stiffness_error_n_per_m: float
    others_m: tuple[float, ...]

    @property
    def stable(self) -> bool:
        """Whether the force falls as the gap grows, beyond doubt."""
        return self.stiffness_n_per_m > self.stiffness_error_n_per_m


def levitate(
    scene: Scene,
    *,
    load_n: float,
    tolerance: float,
    model_tolerance: float,
    device: Device,
    method: str = "auto",
) -> Levitation:
    """The gap under a load; that of ``scene`` does not matter.

    Raises:
        InputError: for a load that is not positive, or one that no gap carries, with the range.
        RunError: where a force near the gap cannot be had to the tolerance.
    """
    if not (isfinite(load_n) and load_n > 0):
        raise InputError(f"load: {load_n:g} N must be a positive force")
    gaps_m = _gaps(scene)
    forces_n = _forces(_at(scene, gaps_m), tolerance=LOOK_TOLERANCE, method="auto", device=device)
    brackets = _brackets(gaps_m, forces_n, load_n)
    if not brackets:
        known = forces_n[np.isfinite(forces_n)]
        carried = (
            f"{known.min():.2g} to {known.max():.2g} N, roughly, without inertia and heat"
            if known.size
            else "none"
        )
        raise InputError(
            f"load: no gap from {gaps_m[0]:.3g} to {gaps_m[-1]:.3g} m carries {load_n:g} N at "
            f"hv = {scene.hv_m:g} m; forces there: {carried}"
        )
    rough = [sqrt(low * high) for low, high in brackets]
    near = replace(scene, h0_m=rough[-1])
    # Terms are decided for this gap and kept: the force must not jump while the gap is sought.
    (chosen,) = decided([near], model_tolerance=model_tolerance, method=method, device=device)

    def force(*gaps: float) -> np.ndarray:
        there = [replace(chosen, h0_m=gap) for gap in gaps]
        found = solve(there, tolerance=tolerance, method=method, device=device)
        if bad := next((each for each in found if each.status != "ok"), None):
            reasons = "; ".join([bad.status, *notes_of(there[0])])
            raise RunError(f"load: no force near h0 = {gaps[0]:.4g} m: {reasons}")
        return np.array([(each.force_n, each.force_error_n) for each in found]).T

    h0_m = _root(lambda gap: float(force(gap)[0, 0]) - load_n, *brackets[-1])
    forces, errors = force(*(h0_m * (1 + STEP * np.array([0, *AROUND]))))
    stiffness, stiffness_error = quotient(forces[1:], errors[1:], h0_m)
    return Levitation(
        scene=replace(chosen, h0_m=h0_m),
        force_n=float(forces[0]),
        force_error_n=float(errors[0]),
        h0_error_m=float((errors[0] + abs(forces[0] - load_n)) / abs(stiffness)),
        stiffness_n_per_m=float(stiffness),
        stiffness_error_n_per_m=float(stiffness_error),
        others_m=tuple(rough[:-1]),
    )


def _gaps(scene: Scene) -> np.ndarray:
    """Gaps to look at, rising, from where the surface comes near to the finger somewhere."""
    least, most = max(scene.hv_m / CLOSEST, GAPS_M[0]), min(scene.hv_m / FARTHEST, GAPS_M[1])
    gap = scene.finger.gap
    if not gap.flat:
        x, y = scene.inside()
        excursion_m = scene.hv_m * scene.magnitude(x, y)
        least = max(least, float((excursion_m / CLOSEST - gap.rise_m(x, y)).max()))
    return np.geomspace(least, max(least, most), LOOKED_AT)


def _at(scene: Scene, gaps_m: np.ndarray) -> list[Scene]:
    """The scene at some gaps, without the terms that the rough look can do without."""
    gas = replace(scene.gas, inertia="none", heat="none")
    return [replace(scene, h0_m=float(gap), gas=gas) for gap in gaps_m]


def _forces(
    scenes: Sequence[Scene], *, tolerance: float, method: str, device: Device
) -> np.ndarray:
    """Mean forces, NaN where there is none."""
    found = solve(scenes, tolerance=tolerance, method=method, device=device)
    return np.array([each.force_n for each in found])


def _brackets(gaps_m: np.ndarray, forces_n: np.ndarray, load_n: float) -> list[tuple[float, float]]:
    """Neighbouring gaps between which the force falls to the load, rising."""
    known = np.isfinite(forces_n)
    gaps, above = gaps_m[known], forces_n[known] >= load_n
    crossed = np.flatnonzero(above[:-1] & ~above[1:])
    return [(float(gaps[k]), float(gaps[k + 1])) for k in crossed]


def _root(excess: Callable[[float], float], low: float, high: float) -> float:
    """The gap without an excess, between two gaps; outside them where terms moved it."""
    from scipy.optimize import brentq

    for _ in range(8):
        if excess(low) >= 0:
            break
        low /= 1.1
    for _ in range(8):
        if excess(high) <= 0:
            break
        high *= 1.1
    try:
        return float(brentq(excess, low, high, rtol=1e-10, xtol=1e-15, maxiter=MOST_STEPS))
    except (ValueError, RuntimeError) as error:
        raise RunError(f"load: the gap was not found between {low:.4g} and {high:.4g} m") from error
