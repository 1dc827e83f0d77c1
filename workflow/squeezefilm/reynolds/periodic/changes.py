"""What the states on a launch's grids say of the error of the last.

Either two grids differ in everything, the last of them being the finer; or the last is judged from
coarser ones, of which the first differs from the second in time alone and the others in space.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from squeezefilm.reynolds.error_estimate import (
    JUDGED_SIZE_SHARE,
    SIZE_SHARE,
    UNKNOWN_FALL,
    Change,
    fall_of,
    left_after,
)
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.terms import Terms

# Least tolerance at which a grid is judged from coarser ones: below, those that tell enough of it
# cost the paper's scenes more than a finer one.
JUDGED_FROM = 2e-5


def judged_from_coarser(terms: Terms, *, tolerance: float) -> bool:
    """Whether the last grid may be judged from coarser ones; not where an estimate has a margin."""
    return margin_of(terms) == 1 and tolerance >= JUDGED_FROM


def margin_of(terms: Terms) -> float:
    """By which the estimates of films with some terms are increased."""
    return max(term.ESTIMATE_MARGIN for term in terms) if terms else 1.0


def least_fall_of(terms: Terms) -> float:
    """The factor below which no changes of films with some terms are believed to fall."""
    return max((term.LEAST_FALL for term in terms), default=0.0)


def how_many_tell(grids: Sequence[Grid]) -> int:
    """How many grids at the end of some tell the error of the last."""
    if len(grids) <= 2 or grids[-1].nt > grids[-2].nt:
        return min(len(grids), 2)
    return 1 + sum(grid.nt == grids[-1].nt for grid in grids)


def changes_of(
    stages: Sequence[np.ndarray],
    *,
    telling: int,
    steps: np.ndarray,
    known: Sequence[Change | None],
    in_time: np.ndarray,
    sizes: np.ndarray,
    least_falls: np.ndarray,
    per_residual: np.ndarray,
    terms: Terms,
    tolerance: float,
) -> tuple[Change | None, np.ndarray, np.ndarray]:
    """Change to the last of films' grids, the factor by which changes fall, error in time.

    Args:
        stages: what is said of the films on each of their grids (``launch.SAID``).
        telling: how many of these tell the error.
        steps: from each film's grid before the last one to that (``step_between``).
        known: each film's change to the first of two grids, if there is one.
        in_time: their errors in time that the change from the first of two grids does not show.
        sizes: shares of the changes' sizes that count of each at least.
        least_falls: factors by which each film's changes are believed to fall at most.
        per_residual: by how much their pressure may be off for the residual that is left.
        terms: those of the films.
    """
    fall = np.full(len(known), UNKNOWN_FALL)
    if telling < 2:
        return None, fall, in_time
    judged = judged_from_coarser(terms, tolerance=tolerance)
    share = JUDGED_SIZE_SHARE if judged else SIZE_SHARE
    shares = np.maximum(share, sizes)
    # The first guess on a grid is the state on the one before.
    changes = [
        Change(np.maximum(said["moment"], shares * said["size"]), said["size"])
        for said in stages[1 - telling :]
    ]
    if telling > 2:
        in_time = left_after(UNKNOWN_FALL) * (
            changes[0].largest + per_residual * _unseen(stages[-telling + 1])
        )
    last = changes[-1]
    which = [at for at, change in enumerate(known) if telling > 3 or change]
    if which and margin_of(terms) == 1:
        before = changes[-2][which] if telling > 3 else _stacked([known[at] for at in which])
        seen = fall_of(before, last[which], step=steps[which])
        # One that falls suddenly, on a later launch's grid, is not believed.
        fall[which] = seen if judged and telling > 3 else np.maximum(seen, UNKNOWN_FALL)
        last.largest[which] = last[which].steady(before).largest
    taken_over = stages[-1]["newton_steps"] == 0
    fall = np.where(taken_over, np.maximum(fall, UNKNOWN_FALL), fall)
    return last + per_residual * _unseen(stages[-1]), np.maximum(fall, least_falls), in_time


def _unseen(said: np.ndarray) -> np.ndarray:
    """Residual by which states would have changed that their grid took over as they are."""
    return np.where(said["newton_steps"] == 0, said["residual"], 0.0)


def _stacked(changes: Sequence[Change | None]) -> Change:
    """Those of several films as one."""
    some = [change for change in changes if change]
    return Change(
        np.array([change.largest for change in some]), np.array([change.size for change in some])
    )
