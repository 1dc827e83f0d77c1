"""Error estimate of a mean gauge pressure from two grids."""

from __future__ import annotations

from math import ceil, isfinite

import numpy as np

from squeezefilm.film.scene import Scenes
from squeezefilm.reynolds.grid import Grid, interpolation_matrices
from squeezefilm.reynolds.terms import Terms, have_velocity_terms

# The moments of a change may be small by chance where its size is not. So this share of the size
# counts too, at tolerances of LOOSE_TOLERANCE and more, whose grids are coarse. Without it two
# films (judged_films.csv in tests/numerics/data) are off by up to four times their estimate, with 2
# % two others by 1.1 times.
CHANGE_SIZE_FRACTION, LOOSE_TOLERANCE = 3e-2, 2e-5
# Where changes fall by a factor q from grid to grid, q/(1 − q) of the last one is left. Grids grow
# by unequal steps: RATIO_SAFETY_FACTOR times that is taken, enough for first order.
# MAX_CONVERGENCE_RATIO limits it to thirty times the change, DEFAULT_CONVERGENCE_RATIO to no less
# than twice, as without two changes.
RATIO_SAFETY_FACTOR = 3.0
MAX_CONVERGENCE_RATIO = 10 / 11
DEFAULT_CONVERGENCE_RATIO = 0.4
# While layers at the edge are thinner than nodes lie apart errors go up and down, and a change is
# small where one turns: the least fall of films with thin layers, without and with inertia or
# thermal effects; a film of the latter (judged_films.csv) is off by 1.04 times its estimate at 0.5.
THIN_LAYER_CONVERGENCE_RATIO, THIN_LAYER_VELOCITY_CONVERGENCE_RATIO = 0.5, 0.6
# Of a gas with inertia, or that warms, changes creep or fall suddenly, so that none tells the next;
# and where waves steepen grids agree by chance in all moments: at all tolerances this fraction
# counts of what the grids resolve of a change, and of that no less than a share of the size, for
# layers at the edge not resolved yet.
VELOCITY_CHANGE_SIZE_FRACTION, UNRESOLVED_CHANGE_FRACTION = 0.7, 0.35
# Share of the coarser grid's modes along each axis that it resolves; with half of them a film (σ
# 2754) was off by 1.3 times its estimate.
RESOLVED_MODES_FRACTION = 0.6
# Round-off: error of the mean gauge pressure relative to the largest gauge pressure.
RELATIVE_ROUND_OFF = 1e-14
# How many times that, over the narrowest gap, an error may be whatever the force: what the
# difference of two grids and an iteration stopped by rounding leave.
ALLOWED_ROUND_OFF_FACTOR = 4


def estimate_errors(
    results: np.ndarray,
    before: np.ndarray,
    *,
    scenes: Scenes,
    terms: Terms,
    of_profile: np.ndarray,
    least: np.ndarray | float,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of films' mean gauge pressures on the last of some grids, and how they changed there.

    A change of the mean pressure is known by the largest of its lowest cosine moments, the first of
    which is the force, no less than a share of the size, and by this, the mean of its magnitude
    over the film: no chance makes the size small.

    Args:
        results: what is said of the films on the last grid (``launch.RESULT_DTYPE``); the first
            guess there is the state on the one before.
        before: each film's change to the grid before, (2, n); NaN where there is none.
        terms: those of the films.
        of_profile: by which what is missed of the profile falls; 0 for a smooth one.
        least: factor by which changes fall at least (``resolution.min_convergence_ratio``).

    Returns:
        The errors; how large they may be; the changes, (2, n).
    """
    # A mass error w moves the pressure by about n w/H.
    residual_error = (
        scenes.gas.polytropic_exponent / scenes.narrowest_gap_ratio * results["residual"]
    )
    size, size_before = results["size"], before[1]
    velocities = have_velocity_terms(terms)
    least_change = CHANGE_SIZE_FRACTION * size if tolerance >= LOOSE_TOLERANCE else 0.0
    if velocities:
        resolved = np.maximum(results["resolved"], UNRESOLVED_CHANGE_FRACTION * size)
        least_change = VELOCITY_CHANGE_SIZE_FRACTION * resolved
    moment = np.maximum(results["moment"], least_change)
    ratio, known = np.full(len(results), DEFAULT_CONVERGENCE_RATIO), ~np.isnan(size_before)
    if known.any() and not velocities:
        # That of the moments, but no less than their sizes': chance may make moments small, or a
        # layer at the edge that the grids do not resolve yet.
        ratios = np.maximum(
            _convergence_ratio(moment, before[0]), _convergence_ratio(size, size_before)
        )
        ratio = np.where(
            known, np.maximum(ratios, DEFAULT_CONVERGENCE_RATIO), DEFAULT_CONVERGENCE_RATIO
        )
        # Moments fall no more than the size does: what goes beyond is chance. Without, films (ε
        # 0.02–0.3, σ 5e4–3e5) were off by 1.5 to 6 times their estimate.
        none = np.zeros(len(results))
        per_size = np.divide(before[0], size_before, out=none, where=size_before > 0)
        moment = np.maximum(moment, per_size * size)
    # A grid that took a state over as it is shows no change: what the residual would have made.
    unmoved = np.where(results["newton_steps"] > 0, 0.0, residual_error)
    change = np.array([moment, size]) + unmoved
    # Of a profile of finite smoothness the size tells the error. There it goes up and down with
    # where the nodes lie beside the kink, and moments agree by chance: of 110 forces with kinks
    # along an axis 4 were off by up to 1.35 times their estimate.
    last_change = np.where(of_profile > 0, change[1], change[0])
    ratio = np.maximum(np.maximum(ratio, of_profile), least)
    round_off = RELATIVE_ROUND_OFF * results["largest"]
    error = error_per_change(ratio) * last_change + residual_error + round_off
    # What rounding leaves, of grids and of the iteration, is no reason for a finer one.
    allowed = (
        tolerance * np.abs(results["mean"])
        + ALLOWED_ROUND_OFF_FACTOR * round_off / scenes.narrowest_gap_ratio
    )
    return error, allowed, change


def resolved_change(before: tuple[Grid, np.ndarray], after: tuple[Grid, np.ndarray]) -> np.ndarray:
    """Return the root mean square of a change in the lowest modes of space, (n,).

    Flow with inertia is not smooth at a corner: between the nodes of a grid its state has up to
    thirty times the error that the force has. That error lies in the higher modes.

    Args:
        before, after: a grid and the means of films' pressures over a period there, (n, nx, ny).
    """
    (coarse, means_before), (fine, means) = before, after
    _, to_fine_x, to_fine_y = interpolation_matrices(coarse, fine, terms=()).values()
    count_x, count_y = (ceil(RESOLVED_MODES_FRACTION * count) for count in (coarse.nx, coarse.ny))
    to_modes_x, to_modes_y = fine.x.eigenmodes[2][:count_x], fine.y.eigenmodes[2][:count_y]
    with np.errstate(invalid="ignore", over="ignore"):  # where there is no state
        change = to_fine_x @ means_before @ to_fine_y.T - means
        return np.asarray(np.linalg.norm(to_modes_x @ change @ to_modes_y.T, axis=(1, 2)))


def _convergence_ratio(change: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Convergence ratios; infinite where there was no change before, and is one now."""
    none = np.where(change > 0, np.inf, 0.0)
    return np.asarray(np.divide(change, before, out=none, where=before > 0))


def error_per_change(ratio: np.ndarray | float) -> np.ndarray:
    """Return the remaining error in units of the last change, for a convergence ratio."""
    q = np.minimum(ratio, MAX_CONVERGENCE_RATIO)
    return np.asarray(RATIO_SAFETY_FACTOR * q / (1 - q))


def too_large_error_text(error: float, *, allowed: float, force: float) -> str:
    """An error that is too large, in the terms of the tolerance: as a share of the force."""
    if force == 0 or not isfinite(error):
        return "the error is not known"
    size = abs(force)
    return f"error {error / size:.1e} of the force, {allowed / size:.1g} allowed"
