"""How far a mean overpressure may be off, from two resolutions: of grids, of modes, of a march."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from squeezefilm.reynolds.grid import Grid

# The force can agree between two grids by chance. The lowest moments of the mean pressure hardly
# ever all do: twice their largest change covered the finer grid's true error in 99.8 % of 414
# pairs of grids, drawn over ε 0.01–0.95 and σ 0.1–3e5.
MOMENTS = 3
MOMENT_FACTOR = 2.0
# In a thin layer at the rim all moments change like the force, which may be by little. So much of
# the mean size of the change counts too: of 120 films (ε 0.02–0.9, σ 0.3–1e5) one, a piston at ε
# 0.87, had 1.5 times its estimate without. Four times as much made pistons at 1e-6 three times as
# dear.
SIZE_SHARE = 5e-4
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


def estimate(
    *,
    change: np.ndarray | float | None,
    left: np.ndarray | float,
    largest: np.ndarray | float,
    narrowest: np.ndarray | float,
    mean: np.ndarray | float,
    tolerance: float,
    margin: float = 1.0,
) -> ErrorEstimate:
    """Error of a mean overpressure after one resolution more; numbers, or arrays over films.

    Args:
        change: change of the mean pressure from the resolution before (``largest_change``); None
            if there is none, which leaves the error unknown.
        left: pressure error that the iteration left.
        largest: largest |p|, which round-off goes by.
        narrowest: least gap over h0.
        mean: the mean overpressure, of which the tolerance is a share.
        margin: by which the estimates of a method are increased.
    """
    floor = ROUND_OFF * np.asarray(largest)
    if change is None:
        error = np.full(floor.shape, np.inf)
    else:
        error = margin * (MOMENT_FACTOR * np.asarray(change) + left) + floor
    # What rounding leaves, of grids and of the iteration, is no reason for a finer one.
    return ErrorEstimate(error, tolerance * np.abs(mean) + ROUNDED * floor / narrowest)


def largest_change(before: np.ndarray, coarse: Grid, after: np.ndarray, fine: Grid) -> np.ndarray:
    """Largest change, from grid to grid, of the mean pressure's lowest cosine moments.

    The first of the moments is the force. No less than a share of the mean size of the change.

    Args:
        before, after: overpressure in the mean over the period, shapes (..., nx, ny).
    """
    carried = coarse.x.interpolation_to(fine.x) @ before @ coarse.y.interpolation_to(fine.y).T
    change = after - carried
    moments = fine.x.moments(MOMENTS) @ change @ fine.y.moments(MOMENTS).T
    size = fine.x.weights @ np.abs(change) @ fine.y.weights
    return np.asarray(np.maximum(np.abs(moments).max(axis=(-2, -1)), SIZE_SHARE * size))


def error_text(error: float, *, allowed: float, force: float) -> str:
    """An error that is too large, in the terms of the tolerance: as a share of the force."""
    if force == 0 or not isfinite(error):
        return "the error is not known"
    size = abs(force)
    return f"error {error / size:.1e} of the force, {allowed / size:.1g} allowed"
