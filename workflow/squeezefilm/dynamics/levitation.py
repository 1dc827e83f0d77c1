"""The gap at which a film carries a load, and the film as a spring there.

The mean force falls as the gap grows: where it equals the load the part floats. Coming down from
above it settles at the widest such gap. Stiffness is that of slow motion, −∂F/∂h0 with the
amplitude of the surface kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import product
from math import ceil, copysign, exp, floor, isfinite, log, log10, nan
from typing import Any, NamedTuple

import numpy as np

from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.film.validity import GAP_RANGE_M, OK, exceeded_limit_texts, validity_texts
from squeezefilm.formatting import number_text, value_text
from squeezefilm.quantities.model_error import (
    AUTO_TERMS,
    ErrorBudget,
    error_budgets,
    resolve_auto_terms,
    unsupported_auto_term_texts,
)
from squeezefilm.quantities.outputs import forces_and_negative_slopes
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.terms import validity_notes

# Gaps that are looked at first, from where the surface nearly touches: hv over them, in equal
# ratios.
MAX_TRIAL_EXCURSION, MIN_TRIAL_EXCURSION, TRIAL_GAP_COUNT = 0.97, 1e-3, 48
TRIAL_FORCE_TOLERANCE = 1e-2
# Relative error of the forces by which a gap is sought before it is refined.
ROUGH_FORCE_TOLERANCE = 1e-3
MAX_ROOT_STEPS = 40
# Rounds of a gap found and its terms decided there, until both agree.
MAX_TERM_ROUNDS = 4
# Gaps of the range of validity that a message names, 2 % apart or less; one of so many is solved
# for, between which forces go nearly as powers of the gap.
RANGE_GAP_COUNT, RANGE_GAPS_PER_FORCE = 377, 8
# Change of ln h0 in a step, and the force over the load that stands for smaller ones.
MAX_LOG_GAP_STEP, MIN_FORCE_OVER_LOAD = 0.2, 1e-6
# A gap is not given where its modelling error is more than this fraction of it.
MAX_RELATIVE_MODELLING_ERROR = 0.1
# Growth of effects, relative, with that of the gap: inertia and the edge loss go with h0².
NEGLECTED_EFFECT_GAP_EXPONENT = 2.0
NO_VALID_GAP_TEXT = "at this amplitude no gap is within the limits of validity"


@dataclass(frozen=True)
class Levitation:
    """A part at rest on a film.

    Attributes:
        scene: the film at the gap found.
        force_n: its mean force, the load to its error.
        h0_error_m: numerical error of the gap, from the force's error and the stiffness.
        stiffness_n_per_m, stiffness_error_n_per_m: −∂F/∂h0 for slow motion.
        budget: what the film equation neglects of the force.
        other_gaps_m: further gaps at which the force equals the load, rough, rising.
        notes: on the terms of the equation: which ``auto`` could not include and why, and which
            the scene stretches.
    """

    scene: Scene
    force_n: float
    h0_error_m: float
    stiffness_n_per_m: float
    stiffness_error_n_per_m: float
    budget: ErrorBudget = field(default_factory=ErrorBudget)
    other_gaps_m: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def is_stable(self) -> bool:
        """Return whether the force falls as the gap grows, by more than its error."""
        return self.stiffness_n_per_m > self.stiffness_error_n_per_m

    @property
    def modelling_error_m(self) -> tuple[float, float]:
        """Return the bounds of the gap's modelling error: the force's over the stiffness.

        Each end is wider by what that misses at second order. NaN where an effect is unknown.
        """
        lower, upper = (self._gap_change_m(bound) for bound in self.budget.modelling_error_percent)
        return lower - self.second_order_error_m(lower), upper + self.second_order_error_m(upper)

    def _gap_change_m(self, percent: float) -> float:
        """Change of the gap, in metres, by a change of the force in per cent."""
        return percent / 100 * self.force_n / abs(self.stiffness_n_per_m)

    def second_order_error_m(self, moved_m: float) -> float:
        """Bound on the second order of a change of the gap.

        With forces ~ h^−m it is (m + 1)/2 of the square of the relative change, and with effects
        that grow with h² twice that square more.
        """
        steepness = abs(self.stiffness_n_per_m) * self.scene.h0_m / abs(self.force_n)
        return (NEGLECTED_EFFECT_GAP_EXPONENT + (steepness + 1) / 2) * moved_m**2 / self.scene.h0_m

    @property
    def known_modelling_error_m(self) -> float:
        """Return the largest size of the gap's modelling error, by the effects that are known."""
        error_m = abs(self._gap_change_m(self.budget.known_error_percent))
        return error_m + self.second_order_error_m(error_m)


def levitate(
    scene: Scene,
    *,
    load_n: float,
    tolerance: float,
    model_tolerance: float,
    device: Device,
    method: str = "auto",
) -> Levitation:
    """Return the gap at which the film carries a load; the gap of ``scene`` is ignored.

    Terms that are ``auto`` are those that a force at this gap has.

    Raises:
        InputError: for a load that is not positive, or one that no gap carries, with the range.
        RunError: where a force near the gap cannot be had to the tolerance, where the gap exceeds a
            limit of validity, and where its known modelling error is too large.
    """
    if not (isfinite(load_n) and load_n > 0):
        raise InputError(f"load: {load_n:g} N must be a positive force")
    how = {"tolerance": tolerance, "method": method, "device": device}
    gaps_m, forces_n = _trial_gaps_and_forces(scene.viscous(), device)
    known = np.isfinite(forces_n)
    gaps, forces = gaps_m[known], forces_n[known]
    above = forces >= load_n
    # Between neighbouring gaps at which the force falls to the load, rising.
    crossed = np.flatnonzero(above[:-1] & ~above[1:])
    rough = [_interpolated_gap(gaps[k : k + 2], forces[k : k + 2], load_n) for k in crossed]
    if not rough:
        carried = "none"
        if known.any():
            lowest, highest = forces.min(), forces.max()
            carried = (
                f"{lowest:.2g} to {highest:.2g} N, roughly, without inertia and thermal effects"
            )
        raise InputError(
            f"load: no gap from {_micrometre_text(gaps_m[0])} to {_micrometre_text(gaps_m[-1])} "
            f"carries {value_text(load_n, 'N')} at hv = {_micrometre_text(scene.hv_m)}; forces "
            f"there: {carried}"
        )
    scene_at_load, note = _scene_at_load(
        scene, rough[-1], load_n=load_n, model_tolerance=model_tolerance, how=how
    )
    notes = [*unsupported_auto_term_texts(scene, method=method), *[note] * bool(note)]
    not_given = f"load: no gap is given for {value_text(load_n, 'N')}: "
    if limits := exceeded_limit_texts(scene_at_load):
        raise RunError(not_given + "; ".join([*limits, *notes]))
    (budget,) = error_budgets([scene_at_load], device=device)
    levitation = replace(
        _levitation_at_gap(scene_at_load, load_n=load_n, how=how),
        other_gaps_m=tuple(other.gap_m for other in rough[:-1]),
        budget=budget,
        notes=(*notes, *validity_notes(scene_at_load)),
    )
    error_m = levitation.known_modelling_error_m
    if budget.status == OK and not error_m <= MAX_RELATIVE_MODELLING_ERROR * scene_at_load.h0_m:
        too_large = (
            f"the gap's modelling error, up to {1e6 * error_m:.2g} µm, is more than a tenth of the "
            "gap"
        )
        raise RunError(not_given + "; ".join([too_large, *notes]))
    return levitation


def valid_range_text(
    scene: Scene, *, device: Device, tolerance: float, model_tolerance: float, method: str
) -> str:
    """Describe the ranges of gaps and loads within the limits of validity at a scene's amplitude.

    With terms as ``levitate`` decides them: limits and forces depend on them, so that there may be
    several ranges. A modelling error may be too large there nevertheless: to know it would take
    longer than a gap.
    """
    gaps_m = _trial_gaps_m(scene, RANGE_GAP_COUNT)
    auto = [name for name in AUTO_TERMS if getattr(scene.gas, name) == "auto"]
    # Whether the limits hold at each gap, for each choice of these terms.
    by_choice = np.array(
        [
            validity_texts(_scenes_at_gaps(scene.with_gas(**chosen), gaps_m)) == OK
            for values in product(("none", "included"), repeat=len(auto))
            for chosen in [dict(zip(auto, values, strict=True))]
        ]
    )
    within = np.flatnonzero(by_choice.any(axis=0))
    if not within.size:
        return NO_VALID_GAP_TEXT
    # With a neighbour at either end, for slopes.
    part = slice(max(within[0] - 1, 0), within[-1] + 2)
    gaps_m, by_choice = gaps_m[part], by_choice[:, part]
    # Terms are decided where the limits depend on them; other gaps have those of the nearest.
    limited = np.flatnonzero(by_choice.any(axis=0) & ~by_choice.all(axis=0))
    limited = limited if limited.size else np.array([len(gaps_m) - 1])
    how: dict[str, Any] = {"method": method, "device": device}
    decided = Scenes.of(
        resolve_auto_terms(
            _scenes_at_gaps(scene, gaps_m[limited]), model_tolerance=model_tolerance, **how
        )
    )
    nearest = np.abs(np.subtract.outer(np.arange(len(gaps_m)), limited)).argmin(axis=1)
    at_gaps = replace(decided[nearest], h0_m=gaps_m)
    within = validity_texts(at_gaps) == OK
    last, changes = len(gaps_m) - 1, np.flatnonzero(np.diff(within))
    known = np.unique([*range(0, last, RANGE_GAPS_PER_FORCE), last, *changes, *changes + 1])
    rough = max(tolerance, TRIAL_FORCE_TOLERANCE)
    known_forces_n = solve(at_gaps[known], tolerance=rough, **how).force_n
    log_gaps = np.log(gaps_m)
    with np.errstate(invalid="ignore", divide="ignore"):
        log_forces = np.interp(log_gaps, log_gaps[known], np.log(known_forces_n))
        valid = within & np.isfinite(log_forces) & (np.gradient(log_forces, log_gaps) < 0)
    ends = np.flatnonzero(np.diff(valid, prepend=False, append=False)).reshape(-1, 2)
    if not ends.size:
        return NO_VALID_GAP_TEXT
    gaps, loads = (
        [_inward_rounded_range_text(values[slice(*run)]) for run in ends]
        for values in (1e6 * gaps_m, np.exp(log_forces))
    )
    ranges = ", ".join(
        f"gaps of about {gap} µm with loads of about {load} N"
        for gap, load in zip(gaps, loads, strict=True)
    )
    return (
        f"at this amplitude the limits of validity hold for {ranges}; give a load well within "
        "them, or a larger pad for a larger load"
    )


def _inward_rounded_range_text(values: np.ndarray) -> str:
    """Return the range of some positive values, its ends rounded inwards to two or three digits."""
    low, high = float(values.min()), float(values.max())
    for digits in (2, 3):
        low_digit, high_digit = (10.0 ** (floor(log10(end)) + 1 - digits) for end in (low, high))
        ends = ceil(low / low_digit) * low_digit, floor(high / high_digit) * high_digit
        if ends[0] < ends[1]:
            return " to ".join(number_text(end, sign="", digits=digits) for end in ends)
    return " to ".join(dict.fromkeys(number_text(end, sign="", digits=3) for end in (low, high)))


def _scene_at_load(
    scene: Scene,
    start: GapAndSteepness,
    *,
    load_n: float,
    model_tolerance: float,
    how: dict[str, Any],
) -> tuple[Scene, str]:
    """Return the scene at the gap at which its force is the load, and a note on its terms, if any.

    Its ``auto`` terms are those decided at this gap. They are kept while the gap is sought, for the
    force must not jump then, so the gap is sought again where they have changed.
    """

    def with_terms_decided(gap_m: float) -> Scene:
        at_gap = _scenes_at_gaps(scene, [gap_m])
        deciding = {"method": how["method"], "device": how["device"]}
        return resolve_auto_terms(at_gap, model_tolerance=model_tolerance, **deciding)[0]

    chosen = with_terms_decided(start.gap_m)
    for _ in range(MAX_TERM_ROUNDS):
        start = _gap_at_load(chosen, start, load_n=load_n, how=how)
        before, chosen = chosen, with_terms_decided(start.gap_m)
        if chosen.gas == before.gas:
            return chosen, ""
    # Each choice leads to a gap at which the other is made: the larger equation is taken.
    names = [name for name in AUTO_TERMS if getattr(chosen.gas, name) != getattr(before.gas, name)]
    chosen = chosen.with_gas(**dict.fromkeys(names, "included"))
    gap_m = _gap_at_load(chosen, start, load_n=load_n, how=how).gap_m
    note = "; ".join(
        f"gas.{name} is auto and included, though a force at this gap may be without it: it "
        "changes the force by about the model tolerance"
        for name in names
    )
    return replace(chosen, h0_m=gap_m), note


def _gap_at_load(
    scene: Scene, start: GapAndSteepness, *, load_n: float, how: dict[str, Any]
) -> GapAndSteepness:
    """Solve force(h0) = load for one set of terms: by rough forces first, then by refined ones.

    A gap outside the limits of validity stays rough.
    """
    tolerance = how["tolerance"]
    rough = how | {"tolerance": max(tolerance, ROUGH_FORCE_TOLERANCE)}

    def log_force_over_load(gap_m: float, how: dict[str, Any]) -> float:
        """Return ln(force/load)."""
        (at_gap,) = _scenes_at_gaps(scene, [gap_m])
        (solution,) = solve([at_gap], **how)
        force_n = float(_require_finite(solution.force_n, at_gap, solution.status))
        return log(max(force_n / load_n, MIN_FORCE_OVER_LOAD))

    rough_gap = _secant_gap_at_load(
        partial(log_force_over_load, how=rough), start, precision=ROUGH_FORCE_TOLERANCE / 10
    )
    # The gap may lie anywhere here; where all of it is outside, none is given.
    ends = (1 + ROUGH_FORCE_TOLERANCE * np.array([-1, 1])) * rough_gap.gap_m
    if all(map(exceeded_limit_texts, _scenes_at_gaps(scene, ends))):
        return rough_gap
    return _secant_gap_at_load(
        partial(log_force_over_load, how=how), rough_gap, precision=tolerance
    )


def _levitation_at_gap(scene: Scene, *, load_n: float, how: dict[str, Any]) -> Levitation:
    """Return force, stiffness and the gap's error at a gap that carries a load."""
    values, (status,) = forces_and_negative_slopes([scene], "h0_m", **how)
    force_n, error_n, stiffness, stiffness_error = _require_finite(
        values[:, 0], scene, status
    ).tolist()
    return Levitation(
        scene=scene,
        force_n=force_n,
        h0_error_m=(error_n + abs(force_n - load_n)) / abs(stiffness),
        stiffness_n_per_m=stiffness,
        stiffness_error_n_per_m=stiffness_error,
    )


def _require_finite(values: Any, scene: Scene, status: str) -> Any:
    """Return values of a scene that are known; raise RunError that names exceeded limits first."""
    if not np.isfinite(values).all():
        no_force = f"no force near h0 = {_micrometre_text(scene.h0_m)}: {status}"
        reasons = [*exceeded_limit_texts(scene), no_force, *validity_notes(scene)]
        raise RunError(f"load: no gap is given: {'; '.join(reasons)}")
    return values


def _scenes_at_gaps(scene: Scene, gaps_m: Sequence[float] | np.ndarray) -> Scenes:
    rows = np.zeros(len(gaps_m), dtype=np.int64)
    return replace(Scenes.of([scene])[rows], h0_m=np.array(gaps_m))


def _trial_gaps_m(scene: Scene, count: int) -> np.ndarray:
    """Return rising gaps, from near contact on."""
    least = max(scene.hv_m / MAX_TRIAL_EXCURSION, GAP_RANGE_M[0])
    most = min(scene.hv_m / MIN_TRIAL_EXCURSION, GAP_RANGE_M[1])
    gap = scene.pad.gap
    if not gap.flat:
        x, y = scene.inside()
        excursion_m = scene.hv_m * np.abs(scene.amplitude(x, y))
        least = max(least, float((excursion_m / MAX_TRIAL_EXCURSION - gap.rise_m(x, y)).max()))
    return np.geomspace(least, max(least, most), count)


@lru_cache(maxsize=1)  # for all loads of a table
def _trial_gaps_and_forces(scene: Scene, device: Device) -> tuple[np.ndarray, np.ndarray]:
    """Return gaps and rough forces there, without the terms that such a look can do without."""
    gaps_m = _trial_gaps_m(scene, TRIAL_GAP_COUNT)
    at_gaps = _scenes_at_gaps(scene, gaps_m)
    return gaps_m, solve(at_gaps, tolerance=TRIAL_FORCE_TOLERANCE, device=device).force_n


class GapAndSteepness(NamedTuple):
    """A gap and −d ln F/d ln h0 there."""

    gap_m: float
    steepness: float


def _interpolated_gap(gaps_m: np.ndarray, forces_n: np.ndarray, load_n: float) -> GapAndSteepness:
    """Return the gap at a load between two, at which the force is above and below it."""
    more, less = np.log(np.maximum(forces_n / load_n, MIN_FORCE_OVER_LOAD)).tolist()
    far = log(gaps_m[1] / gaps_m[0])
    steepness = (more - less) / far
    return GapAndSteepness(float(gaps_m[0]) * exp(more / steepness), steepness)


def _secant_gap_at_load(
    excess: Callable[[float], float], start: GapAndSteepness, *, precision: float
) -> GapAndSteepness:
    """Return the gap at which ``excess``, ln(force/load), is 0, to a relative precision.

    By the secant method over ln h0, for forces go nearly as powers of the gap.
    """
    gap_m, steepness = start
    last_m, before = gap_m, nan
    for _ in range(MAX_ROOT_STEPS):
        value = excess(gap_m)
        apart = log(gap_m / last_m)
        # Of nearer gaps the quotient shows the forces' errors.
        if abs(apart) > ROUGH_FORCE_TOLERANCE:
            steepness = (before - value) / apart
        last_m, before = gap_m, value
        # Where the force rises with the gap, on towards where it falls to the load.
        move = value / steepness if steepness > 0 else copysign(MAX_LOG_GAP_STEP, value)
        move = min(max(move, -MAX_LOG_GAP_STEP), MAX_LOG_GAP_STEP)
        gap_m *= exp(move)
        if abs(move) <= precision:
            return GapAndSteepness(gap_m, steepness)
    raise RunError(f"load: the gap near {_micrometre_text(start.gap_m)} was not found")


def _micrometre_text(length_m: float) -> str:
    return f"{1e6 * length_m:.4g} µm"
