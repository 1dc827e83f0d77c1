"""Error estimate of a mean gauge pressure from two grids."""

from __future__ import annotations

from functools import lru_cache
from math import isfinite

import numpy as np

from squeezefilm.film.scene import Scenes
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.terms import Terms, size_share_of

# In a thin layer at the rim all moments change like the force, which may be by little. So much of
# the mean size of the change counts too: of 120 films (ε 0.02–0.9, σ 0.3–1e5) one, a piston at ε
# 0.87, had 1.5 times its estimate without. On the coarser grids of a loose tolerance narrow spots
# ask for more: of 129 films one (ε 0.2, σ 4e3) had 2.2 times its estimate with a share of 5e-3.
# At 1e-6 that much would cost the paper's scenes a tenth of their iterations more.
SIZE_SHARE, LOOSE_SIZE_SHARE, LOOSE_FROM = 5e-4, 2e-2, 2e-5
# Where changes fall by a factor q from grid to grid, q/(1 − q) of the last one is left. Grids grow
# by unequal steps: FALL_FACTOR times that is taken, enough for first order. No more than MOST_ORDER
# is believed, nor less than MOST_FALL; without two changes UNKNOWN_FALL makes it twice the change.
FALL_FACTOR = 3.0
MOST_ORDER = 14
MOST_FALL = 10 / 11
UNKNOWN_FALL = 0.4
# While layers at the rim are thinner than nodes lie apart errors go up and down, and a change is
# small where one turns: of 1359 films (σ 1e4–1e5) 40 were off by up to 2.6 times their estimate
# without a least fall of those with thin layers, by 0.75 with it. With 0.45 one more was, of 1246.
THIN_LAYER_FALL = 0.5
# Share of the tolerance that Newton's iteration may leave; the resolution gets the rest.
ITERATION_SHARE = 0.2
# Round-off: error of the mean overpressure relative to the largest overpressure.
ROUND_OFF = 1e-14
# How many times that, over the narrowest gap, an error may be whatever the force: what the
# difference of two grids and an iteration stopped by rounding leave.
ROUNDED = 4


def estimate(
    said: np.ndarray,
    before: np.ndarray,
    *,
    scenes: Scenes,
    terms: Terms,
    grids: tuple[Grid, Grid],
    of_profile: np.ndarray,
    least: np.ndarray | float,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of films' mean overpressures on the last of some grids, and how they changed there.

    A change of the mean pressure is known by the largest of its lowest cosine moments, the first of
    which is the force, no less than a share of the size, and by this, the mean of its magnitude
    over the film: no chance makes the size small.

    Args:
        said: what is said of the films on the last grid (``launch.SAID``); the first guess there
            is the state on the one before.
        before: each film's change to the grid before, (2, n); NaN where there is none.
        terms: those of the films.
        grids: the last two, (coarse, fine).
        of_profile: by which what is missed of the profile falls; 0 for a smooth one.
        least: factor by which changes fall at least (``resolution.least_fall``).

    Returns:
        The errors; how large they may be; the changes, (2, n).
    """
    margin, narrowest = margin_of(terms), scenes.narrowest
    # A mass error w moves the pressure by about n w/H.
    per_residual = scenes.gas.polytropic_exponent / narrowest
    size, residual, moved = said["size"], said["residual"], said["newton_steps"] > 0
    loose = margin == 1 and tolerance >= LOOSE_FROM
    share = size_share_of(scenes, terms, least=LOOSE_SIZE_SHARE if loose else SIZE_SHARE)
    largest = np.maximum(said["moment"], share * size)
    fall: np.ndarray | float = UNKNOWN_FALL
    again = ~np.isnan(before[1])
    if margin == 1 and again.any():
        new = np.array([largest, size])
        none = np.where(new > 0, np.inf, 0.0)  # how much they fell where there was none before
        moments, sizes = np.divide(new, before, out=none, where=before > 0)
        coarse, fine = (grid.across[: 1 if grid.radial else 2] for grid in grids)
        step = max(n / finer for n, finer in zip(coarse, fine, strict=True)) ** MOST_ORDER
        # That of the moments, but no less than their sizes': chance may make moments small, or a
        # layer at the rim that the grids do not resolve yet. Changes that fall suddenly are not
        # believed.
        falls = np.maximum(np.maximum(np.maximum(moments, sizes), step), UNKNOWN_FALL)
        fall = np.where(again, falls, fall)
        # Moments fall no more than the size does: what goes beyond is chance. Without, films (ε
        # 0.02–0.3, σ 5e4–3e5) were off by 1.5 to 6 times their estimate.
        was = np.divide(before[0], before[1], out=np.zeros(len(said)), where=before[1] > 0)
        largest = np.maximum(largest, was * size)
    change = np.array([largest, size])
    if not moved.all():
        # A grid that took a state over as it is shows no change: what the residual would have made.
        change += per_residual * np.where(moved, 0.0, residual)
    # Of a profile of finite smoothness the size tells the error. There it goes up and down with
    # where the nodes lie beside the kink, and moments agree by chance: of 110 forces with kinks
    # along an axis 4 were off by up to 1.35 times their estimate.
    telling = np.where(of_profile > 0, change[1], change[0])
    fall = np.maximum(np.maximum(fall, of_profile), np.maximum(least, least_fall_of(terms)))
    floor = ROUND_OFF * said["largest"]
    error = margin * (left_after(fall) * telling + per_residual * residual) + floor
    # What rounding leaves, of grids and of the iteration, is no reason for a finer one.
    return error, tolerance * np.abs(said["mean"]) + ROUNDED * floor / narrowest, change


def left_after(fall: np.ndarray | float) -> np.ndarray:
    """Return the remaining error in units of the last change, for a convergence ratio."""
    q = np.minimum(fall, MOST_FALL)
    return np.asarray(FALL_FACTOR * q / (1 - q))


@lru_cache(maxsize=64)
def margin_of(terms: Terms) -> float:
    """Return the factor on the error estimates of films with some terms."""
    return max(term.ESTIMATE_MARGIN for term in terms) if terms else 1.0


@lru_cache(maxsize=64)
def least_fall_of(terms: Terms) -> float:
    """Lower bound on the convergence ratio of films with some terms."""
    return max((term.LEAST_FALL for term in terms), default=0.0)


def error_text(error: float, *, allowed: float, force: float) -> str:
    """An error that is too large, in the terms of the tolerance: as a share of the force."""
    if force == 0 or not isfinite(error):
        return "the error is not known"
    size = abs(force)
    return f"error {error / size:.1e} of the force, {allowed / size:.1g} allowed"
