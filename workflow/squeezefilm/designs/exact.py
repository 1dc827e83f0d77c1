"""Exact D-optimal designs: so many points out of a list of candidates, each at most once.

A simulation has no scatter: a second one at the same point teaches nothing, and one close by
hardly anything. So no candidate is taken twice, and a least distance between points may be asked
for. The search is an exchange (Fedorov 1972), one point at a time; `optimal` has a bound of how far
from the best its outcome can be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from squeezefilm.designs.optimal import Array, Indices, stacked_derivatives
from squeezefilm.errors import InputError

START_INFORMATION = 1e-6
"""Information of the search at its start, as a share of the candidates' mean: M is never singular.
"""


def exchange(
    derivatives: ArrayLike,
    points: int,
    *,
    existing: ArrayLike | None = None,
    coordinates: ArrayLike | None = None,
    existing_coordinates: ArrayLike | None = None,
    separation: float = 0.0,
    starts: int = 8,
    seed: int = 1,
) -> Indices:
    """The best design found of so many candidates, none twice, by exchange from several starts.

    Returns the candidates chosen, in ascending order.

    Args:
        derivatives: of the candidates, shape (n, p), or (K, n, p) for K parameter vectors whose
            mean log-determinant counts.
        points: how many to choose.
        existing: derivatives of points that stay as they are, shape (m, p) or (K, m, p).
        coordinates: of the candidates, shape (n, c), in which distances are taken; with
            existing_coordinates, shape (m, c), existing points are kept away from too.
        separation: least distance between two points of the design.

    Raises InputError where no candidate is left that is far enough from the others, or where the
    points cannot tell the parameters apart.
    """
    f = stacked_derivatives(derivatives)
    size = np.sqrt(np.mean(f**2, axis=1, keepdims=True))
    if points < 1:
        raise InputError(f"design: {points} points are none; ask for one at least")
    if not np.all(size > 0):
        raise InputError("design: a parameter has no influence on any candidate")
    old = f[:, :0] if existing is None else stacked_derivatives(existing)
    places = None if coordinates is None else np.asarray(coordinates, dtype=float)
    allowed = np.any(f != 0, axis=(0, 2))
    if places is not None and existing_coordinates is not None:
        near = _distances(places, np.asarray(existing_coordinates, dtype=float))
        allowed &= ~np.any(near < max(separation, 1e-9), axis=1)
    search = _Search(f / size, _squares(old / size), places, separation, allowed)
    rng = np.random.default_rng(seed)
    best, highest = np.empty(0, dtype=int), -np.inf
    for start in range(starts):
        # The first start is greedy from nothing, the others from one or more random points.
        chosen = search.improved(search.grown(search.drawn(min(start, points), rng), points))
        log_det = search.log_det(chosen)
        if log_det > highest:
            best, highest = np.sort(chosen), log_det
    if not np.isfinite(highest):
        raise InputError("design: the points cannot tell the parameters apart; ask for more points")
    return best


@dataclass(frozen=True, eq=False)
class _Search:
    """Candidates with derivatives (K, n, p), and the information known before, (K, p, p)."""

    derivatives: Array
    known: Array
    coordinates: Array | None
    separation: float
    allowed: np.ndarray

    def free(self, chosen: Indices) -> Indices:
        """The candidates that may join the points chosen."""
        free = self.allowed.copy()
        free[chosen] = False
        if self.coordinates is not None and self.separation > 0 and len(chosen):
            gaps = _distances(self.coordinates, self.coordinates[chosen])
            free &= np.all(gaps >= self.separation * (1 - 1e-9), axis=1)
        return np.flatnonzero(free)

    def drawn(self, count: int, rng: np.random.Generator) -> Indices:
        """Random points, as many as have room."""
        chosen = np.empty(0, dtype=int)
        for _ in range(count):
            if len(free := self.free(chosen)):
                chosen = np.append(chosen, rng.choice(free))
        return chosen

    def grown(self, chosen: Indices, points: int) -> Indices:
        """The points chosen and more, each time the one with the largest gain."""
        while len(chosen) < points:
            free = self.free(chosen)
            if not len(free):
                raise InputError(
                    f"design: only {len(chosen)} of {points} points fit in; ask for fewer, a "
                    "smaller separation or more candidates"
                )
            matrix = self.known + _squares(self.derivatives[:, chosen])
            inverse = np.linalg.inv(matrix + START_INFORMATION * np.eye(matrix.shape[1]))
            f = self.derivatives[:, free]
            gain = np.log1p(np.einsum("kni,kni->kn", f @ inverse, f)).mean(axis=0)
            chosen = np.append(chosen, free[np.argmax(gain)])
        return chosen

    def improved(self, chosen: Indices) -> Indices:
        """The points exchanged one by one until no exchange helps."""
        best, tried = self.log_det(chosen), 0
        while tried < len(chosen):
            other = self.grown(chosen[1:], len(chosen))  # the first point for the best one
            value = self.log_det(other)
            tried = 0 if value > best + 1e-10 else tried + 1
            best, chosen = (value, other) if tried == 0 else (best, np.roll(chosen, -1))
        return chosen

    def log_det(self, chosen: Indices) -> float:
        """Mean log det of the information; minus infinity where it is singular."""
        matrix = self.known + _squares(self.derivatives[:, chosen])
        if np.linalg.cond(matrix).max() > 1e14:
            return -np.inf
        return float(np.linalg.slogdet(matrix)[1].mean())


def _squares(f: Array) -> Array:
    """F'F of each layer, shape (K, p, p)."""
    return np.asarray(f.transpose(0, 2, 1) @ f)


def _distances(points: Array, others: Array) -> Array:
    return np.asarray(np.linalg.norm(points[:, None] - others[None], axis=-1))
