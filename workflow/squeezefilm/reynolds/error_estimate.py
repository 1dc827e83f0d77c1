"""How far a mean overpressure may be off, from two grids."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.terms import Terms

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


@dataclass(frozen=True)
class ErrorEstimate:
    """Errors of mean overpressures and how large they may be, for one film or for several."""

    error: np.ndarray
    allowed: np.ndarray

    @property
    def holds(self) -> np.ndarray:
        """Whether the tolerance is kept; not where the error is not known."""
        return np.asarray(self.error <= self.allowed)


@dataclass(frozen=True)
class Change:
    """How the mean pressure changes from one grid to the next, for one film or for several.

    Attributes:
        largest: of its lowest cosine moments, the first of which is the force; no less than a
            share of the size.
        size: mean of the change's magnitude over the film: no chance makes it small.
    """

    largest: np.ndarray
    size: np.ndarray

    def __add__(self, more: np.ndarray | float) -> Change:
        """With a change of the whole film beside it."""
        return Change(self.largest + more, self.size + more)

    def telling(self, of_profile: np.ndarray | float) -> np.ndarray:
        """What of it tells the error: of a profile of finite smoothness, the size.

        There an error goes up and down with where the nodes lie beside the kink, and moments agree
        by chance: of 110 forces with kinks along an axis 4 were off by up to 1.35 times their
        estimate.

        Args:
            of_profile: by which what is missed of the profile falls; 0 for a smooth one.
        """
        return np.asarray(np.where(np.asarray(of_profile) > 0, self.size, self.largest))

    def steady(self, before: Change) -> Change:
        """With moments that fall no more than the size does: what goes beyond is chance.

        Without, films (ε 0.02–0.3, σ 5e4–3e5) were off by 1.5 to 6 times their estimate.
        """
        was = np.divide(
            before.largest, before.size, out=np.zeros_like(self.size), where=before.size > 0
        )
        return Change(np.maximum(self.largest, was * self.size), self.size)

    def __getitem__(self, film: np.ndarray) -> Change:
        return Change(self.largest[film], self.size[film])


def estimate(
    *,
    change: np.ndarray | float | None,
    left: np.ndarray | float,
    largest: np.ndarray | float,
    narrowest: np.ndarray | float,
    mean: np.ndarray | float,
    tolerance: float,
    fall: np.ndarray | float = UNKNOWN_FALL,
    margin: float = 1.0,
) -> ErrorEstimate:
    """Error of a mean overpressure after one resolution more; numbers, or arrays over films.

    Args:
        change: change of the mean pressure from the resolution before (``Change.telling``); None
            if there is none, which leaves the error unknown.
        left: pressure error that the iteration left.
        largest: largest |p|, which round-off goes by.
        narrowest: least gap over h0.
        mean: the mean overpressure, of which the tolerance is a share.
        fall: factor by which changes fall from resolution to resolution (``fall_of``).
        margin: by which the estimates of a method are increased.
    """
    floor = ROUND_OFF * np.asarray(largest)
    if change is None:
        error = np.full(floor.shape, np.inf)
    else:
        error = margin * (left_after(fall) * np.asarray(change) + left) + floor
    # What rounding leaves, of grids and of the iteration, is no reason for a finer one.
    return ErrorEstimate(error, tolerance * np.abs(mean) + ROUNDED * floor / narrowest)


def left_after(fall: np.ndarray | float) -> np.ndarray:
    """What is left after a change, in units of it, where changes fall by a factor."""
    q = np.minimum(fall, MOST_FALL)
    return np.asarray(FALL_FACTOR * q / (1 - q))


def step_between(coarse: Grid, fine: Grid) -> float:
    """How many nodes one grid has for one of the other, along the axis where it has most."""
    return max(coarse.nx / fine.nx, coarse.ny / fine.ny)


def fall_of(before: Change, after: Change, *, step: np.ndarray | float) -> np.ndarray:
    """Factor by which changes fall from one to that between two grids, a ``step_between`` apart.

    That of the moments, but no less than their sizes': chance may make moments small, or a layer at
    the rim that the grids do not resolve yet.
    """
    moments, sizes = (
        np.divide(new, old, out=np.where(new > 0, np.inf, 0.0), where=old > 0)
        for new, old in ((after.largest, before.largest), (after.size, before.size))
    )
    return np.asarray(np.maximum(np.maximum(moments, sizes), step**MOST_ORDER))


def change_of(
    said: np.ndarray,
    *,
    known: Change,
    step: float,
    sizes: np.ndarray,
    per_residual: np.ndarray,
    terms: Terms,
    tolerance: float,
) -> tuple[Change, np.ndarray]:
    """Change of films' mean pressures to the last of their grids, factor by which changes fall.

    Args:
        said: what is said of the films on the last grid (``states.SAID``); the first guess there
            is the state on the one before.
        known: each film's change to the grid before; NaN where there is none.
        step: from the grid before the last one to that (``step_between``).
        sizes: shares of the changes' sizes that count of each at least.
        per_residual: by how much their pressure may be off for the residual that is left.
        terms: those of the films.
    """
    loose = margin_of(terms) == 1 and tolerance >= LOOSE_FROM
    shares = np.maximum(LOOSE_SIZE_SHARE if loose else SIZE_SHARE, sizes)
    change = Change(np.maximum(said["moment"], shares * said["size"]), said["size"])
    fall = np.full(len(said), UNKNOWN_FALL)
    which = np.flatnonzero(~np.isnan(known.size))
    if which.size and margin_of(terms) == 1:
        before = known[which]
        # Changes that fall suddenly are not believed.
        fall[which] = np.maximum(fall_of(before, change[which], step=step), UNKNOWN_FALL)
        change.largest[which] = change[which].steady(before).largest
    # A grid that took a state over as it is shows no change: what the residual would have made.
    unseen = np.where(said["newton_steps"] == 0, said["residual"], 0.0)
    return change + per_residual * unseen, fall


def margin_of(terms: Terms) -> float:
    """By which the estimates of films with some terms are increased."""
    return max(term.ESTIMATE_MARGIN for term in terms) if terms else 1.0


def least_fall_of(terms: Terms) -> float:
    """The factor below which no changes of films with some terms are believed to fall."""
    return max((term.LEAST_FALL for term in terms), default=0.0)


def error_text(error: float, *, allowed: float, force: float) -> str:
    """An error that is too large, in the terms of the tolerance: as a share of the force."""
    if force == 0 or not isfinite(error):
        return "the error is not known"
    size = abs(force)
    return f"error {error / size:.1e} of the force, {allowed / size:.1g} allowed"
