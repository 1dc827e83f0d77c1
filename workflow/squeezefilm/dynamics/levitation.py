"""The gap at which a film carries a load, and the film as a spring there.

The mean force falls as the gap grows: where it equals the load the part floats. Coming down from
above it settles at the widest such gap. Stiffness is that of slow motion, −∂F/∂h0 with the
amplitude of the surface kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import isfinite, nan, sqrt

import numpy as np

from squeezefilm.dynamics.averaged_film import averaged_film_of, refused
from squeezefilm.dynamics.response import MOST_MODULATION
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import GAPS_M, exceeded
from squeezefilm.quantities.model_error import (
    OPEN,
    ErrorBudget,
    error_budgets,
    excluded_terms,
    resolve_auto_terms,
    with_term,
)
from squeezefilm.quantities.outputs import AROUND, STEP, quotient
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.terms import notes_of

# Gaps that are looked at first, from where the surface nearly touches: hv over them, in equal
# ratios.
CLOSEST, FARTHEST, LOOKED_AT = 0.97, 1e-3, 48
LOOK_TOLERANCE = 1e-2
# Relative error of the forces by which a gap is sought before it is refined.
ROUGH_TOLERANCE = 1e-3
MOST_STEPS = 40
# A gap is not given where its modelling error is more than this fraction of it.
MOST_MODELLING_ERROR = 0.1
# Of the averaged film's settled force. Up to there the stiffness is within 1 % of the full
# equation's (on strips, σ 20–2700, ε 0.1–0.8).
MOST_AVERAGING_ERROR = 0.2
# Imaginary part over size of a root from which on it is an oscillation, and no numerical noise.
LEAST_OSCILLATION = 1e-3
DAMPED = "no oscillation: gas that is pressed out damps the motion away (overdamped)"


@dataclass(frozen=True)
class Levitation:
    """A part at rest on a film.

    Attributes:
        scene: the film at the gap found.
        force_n, force_error_n: its mean force, the load to its error.
        h0_error_m: numerical error of the gap, from the force's error and the stiffness.
        stiffness_n_per_m, stiffness_error_n_per_m: −∂F/∂h0 for slow motion.
        others_m: further gaps at which the force equals the load, rough, rising.
        budget: what the film equation neglects of the force.
        notes: on the terms of the equation: which ``auto`` could not include and why, and which
            the scene stretches.
    """

    scene: Scene
    force_n: float
    force_error_n: float
    h0_error_m: float
    stiffness_n_per_m: float
    stiffness_error_n_per_m: float
    others_m: tuple[float, ...]
    budget: ErrorBudget
    notes: tuple[str, ...] = ()

    @property
    def stable(self) -> bool:
        """Whether the force falls as the gap grows, beyond doubt."""
        return self.stiffness_n_per_m > self.stiffness_error_n_per_m

    @property
    def modelling_error_m(self) -> tuple[float, float]:
        """Lower and upper end of the gap's: the force's, by the budget, over the stiffness.

        NaN where an effect is not known.
        """
        per_percent_m = self.force_n / abs(self.stiffness_n_per_m) / 100
        lower, upper = self.budget.modelling_error_percent
        return lower * per_percent_m, upper * per_percent_m

    @property
    def untrustworthy(self) -> list[str]:
        """Why the gap says nothing of a real film, in words; empty where it does."""
        reasons = list(exceeded(self.scene))
        error_m = max(map(abs, replace(self, budget=self.budget.known).modelling_error_m))
        if not error_m <= MOST_MODELLING_ERROR * self.scene.h0_m:
            names = ", ".join(self.budget.above_range)
            above = f" (above the range of first orders: {names})" if names else ""
            reasons.append(
                f"the gap's modelling error, up to {1e6 * error_m:.2g} µm{above}, is more than a "
                f"tenth of the gap"
            )
        return reasons


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
        RunError: where a force near the gap cannot be had to the tolerance, or where the gap says
            nothing of a real film (``Levitation.untrustworthy``).
    """
    if not (isfinite(load_n) and load_n > 0):
        raise InputError(f"load: {load_n:g} N must be a positive force")
    how = _How(tolerance=tolerance, method=method, device=device)
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
    (chosen,) = resolve_auto_terms(
        [near], model_tolerance=model_tolerance, method=method, device=device
    )
    found, not_included = _with_what_converges(near, chosen, brackets[-1], load_n=load_n, how=how)
    (budget,) = error_budgets([found.scene], device=device)
    notes = excluded_terms(near, method=method)
    for name, reason in not_included.items():
        known = budget.effects[name].usable
        effect = "its first order is in the modelling error" if known else "its effect is unknown"
        notes.append(f"gas.{name} is auto and not included: {reason}; {effect}")
    stretched = notes_of(found.scene)
    found = replace(found, others_m=tuple(rough[:-1]), budget=budget, notes=(*notes, *stretched))
    if reasons := found.untrustworthy:
        text = "; ".join([*reasons, *notes])
        raise RunError(f"load: no gap is given for {load_n:g} N: {text}")
    return found


def trustworthy(
    scene: Scene, *, tolerance: float, model_tolerance: float, device: Device, method: str = "auto"
) -> str:
    """The gaps, and loads, that are given at a scene's amplitude, roughly and in words."""
    gaps_m = _gaps(scene)
    forces_n = _forces(_at(scene, gaps_m), tolerance=LOOK_TOLERANCE, method="auto", device=device)
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = np.gradient(forces_n, gaps_m)
    # Outside the limits even of the equation that has the most of them there is no need to ask.
    open_to_all = replace(scene, gas=replace(scene.gas, inertia="included", heat="none"))
    some = [
        k
        for k, gap in enumerate(gaps_m)
        if slopes[k] < 0 < forces_n[k] and not exceeded(replace(open_to_all, h0_m=float(gap)))
    ]
    scenes = resolve_auto_terms(
        [replace(scene, h0_m=float(gaps_m[k])) for k in some],
        model_tolerance=model_tolerance,
        method=method,
        device=device,
    )
    given = [
        k
        for k, there, budget in zip(some, scenes, error_budgets(scenes, device=device), strict=True)
        if not Levitation(there, forces_n[k], nan, nan, -slopes[k], nan, (), budget).untrustworthy
    ]
    if not given:
        return "at this amplitude no gap is given"
    gaps, loads = (
        " to ".join(dict.fromkeys(f"{values[k]:.2g}" for k in (given[0], given[-1])))
        for values in (1e6 * gaps_m, forces_n)
    )
    return f"at this amplitude gaps are given of about {gaps} µm, for about {loads} N"


@dataclass(frozen=True)
class _How:
    """How forces are solved for while a gap is sought."""

    tolerance: float
    method: str
    device: Device

    def forces(self, scene: Scene, *gaps_m: float) -> np.ndarray:
        """Mean forces and their errors at some gaps of a scene, shape (2, n)."""
        there = [replace(scene, h0_m=gap) for gap in gaps_m]
        found = solve(there, tolerance=self.tolerance, method=self.method, device=self.device)
        if bad := next((each for each in found if each.status != "ok"), None):
            raise RunError(f"load: no force near h0 = {gaps_m[0]:.4g} m: {bad.status}")
        return np.array([(each.force_n, each.force_error_n) for each in found]).T


def _with_what_converges(
    near: Scene, chosen: Scene, bracket: tuple[float, float], *, load_n: float, how: _How
) -> tuple[Levitation, dict[str, str]]:
    """The gap, without terms that are ``auto`` and keep its force from being found, and why.

    Heat goes first, then inertia.
    """
    not_included: dict[str, str] = {}
    open_ = [name for name in reversed(OPEN) if getattr(near.gas, name) == "auto"]
    while True:
        try:
            return _at_the_load(chosen, bracket, load_n=load_n, how=how), not_included
        except RunError as error:
            name = next((n for n in open_ if getattr(chosen.gas, n) == "included"), None)
            if name is None:
                reasons = "; ".join([str(error), *notes_of(chosen)])
                raise RunError(reasons) from error
            not_included[name] = str(error).removeprefix("load: ")
            chosen = with_term(chosen, name, "none")


def _at_the_load(
    scene: Scene, bracket: tuple[float, float], *, load_n: float, how: _How
) -> Levitation:
    """The gap of one equation, without its budget: sought with rough forces, then refined."""
    rough = replace(how, tolerance=max(how.tolerance, ROUGH_TOLERANCE))
    h0_m = _root(lambda gap: float(rough.forces(scene, gap)[0, 0]) - load_n, *bracket)
    forces, errors = rough.forces(scene, *_around(h0_m))
    slope, _ = quotient(forces, errors, h0_m)
    for _ in range(MOST_STEPS):
        step_m = float(how.forces(scene, h0_m)[0, 0] - load_n) / slope
        h0_m += step_m
        if abs(step_m) <= how.tolerance * h0_m:
            break
        if not abs(step_m) <= STEP * h0_m:
            raise RunError(f"load: the gap near {h0_m:.4g} m was not found to the tolerance")
    forces, errors = how.forces(scene, h0_m, *_around(h0_m))
    stiffness, stiffness_error = quotient(forces[1:], errors[1:], h0_m)
    return Levitation(
        scene=replace(scene, h0_m=h0_m),
        force_n=float(forces[0]),
        force_error_n=float(errors[0]),
        h0_error_m=float((errors[0] + abs(forces[0] - load_n)) / abs(stiffness)),
        stiffness_n_per_m=float(stiffness),
        stiffness_error_n_per_m=float(stiffness_error),
        others_m=(),
        budget=ErrorBudget(),
    )


def _around(h0_m: float) -> list[float]:
    """Gaps about one for a difference quotient."""
    return [h0_m * (1 + step * STEP) for step in AROUND]


def _gaps(scene: Scene) -> np.ndarray:
    """Gaps to look at, rising, from where the surface comes near to the finger somewhere."""
    least, most = max(scene.hv_m / CLOSEST, GAPS_M[0]), min(scene.hv_m / FARTHEST, GAPS_M[1])
    gap = scene.finger.gap
    if not gap.flat:
        x, y = scene.inside()
        excursion_m = scene.hv_m * np.abs(scene.amplitude(x, y))
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
    """The gap without an excess, roughly, between two gaps; outside them where terms moved it."""
    from scipy.optimize import brentq

    excess = cache(excess)
    for _ in range(8):
        if excess(low) >= 0:
            break
        low /= 1.1
    for _ in range(8):
        if excess(high) <= 0:
            break
        high *= 1.1
    try:
        return float(
            brentq(excess, low, high, rtol=ROUGH_TOLERANCE / 10, xtol=1e-15, maxiter=MOST_STEPS)
        )
    except (ValueError, RuntimeError) as error:
        raise RunError(f"load: the gap was not found between {low:.4g} and {high:.4g} m") from error


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
    """The slowest free oscillation of a mass that floats, vertically, of a small motion.

    The film's stiffness rises with the frequency, from that of slow motion, with gas that comes and
    goes through the rim, to that of gas that stays; in between the gas that is pressed out damps.
    So free motion exp(st) of a mass m is a root of its equation of motion with the film's stiffness
    at that complex s,

        m s² + k + K(s/ω) − K(0) = 0,   s = −ζ ωₙ ± i ωₙ √(1 − ζ²),

    k the stiffness of slow motion of the settled film and K that of the averaged film
    (averaged_film.py); without inertia and heat of the gas, which matter at the vibration's
    frequency.
    """
    scene = found.scene
    if not found.stable:
        return Resonance(nan, nan, "no resonance: not stable")
    settled = replace(scene, gas=replace(scene.gas, inertia="none", heat="none"))
    if reason := refused(settled):
        return _unknown(reason)
    film, error = averaged_film_of(settled)
    if error > MOST_AVERAGING_ERROR:
        return _unknown(f"the averaged film's settled force is {error:.0%} off")
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
