"""Exact D-optimal designs: so many points out of a list of candidates, each at most once.

A simulation has no scatter: a second one at the same point teaches nothing, and one close by
hardly anything. So no candidate is taken twice, and a least distance between points may be asked
for. The search is Fedorov's exchange (1972), one point at a time; `optimal_design` says how far
from the best its outcome can be.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.designs.optimal_design import stacked_derivatives
from squeezefilm.io.errors import InputError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

START_INFORMATION = 1e-6
"""Information that a search starts with, as a share of the candidates' mean: M is never singular.
"""


@dataclass(frozen=True, eq=False)
class ExactDesign:
    """The candidates chosen, in ascending order, and the mean of log det F'F over K vectors.

    F includes the existing points.
    """

    chosen: Indices
    log_det: float


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
) -> ExactDesign:
    """The best design found of so many candidates, none twice, by exchange from several starts.

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
    search = _Search.of(derivatives, existing, coordinates, existing_coordinates, separation)
    if points < 1:
        raise InputError(f"design: {points} points are none; ask for one at least")
    rng = np.random.default_rng(seed)
    best = ExactDesign(np.empty(0, dtype=int), -np.inf)
    for start in range(starts):
        # The first start is greedy from nothing, the others from one or more random points.
        drawn = min(start, points)
        chosen = search.grown(search.random(drawn, rng), points)
        found = search.improved(chosen)
        if found.log_det > best.log_det:
            best = found
    if not np.isfinite(best.log_det):
        raise InputError("design: the points cannot tell the parameters apart; ask for more points")
    return best


@dataclass(frozen=True, eq=False)
class _Search:
    derivatives: Array  # (K, n, p), scaled to a plain mean information of about one
    prior: Array
    known: Array  # (K, p, p)
    scale_log_det: float
    coordinates: Array | None
    separation: float
    allowed: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        derivatives: ArrayLike,
        existing: ArrayLike | None,
        coordinates: ArrayLike | None,
        existing_coordinates: ArrayLike | None,
        separation: float,
    ) -> _Search:
        f = stacked_derivatives(derivatives)
        layers, _, parameters = f.shape
        size = np.sqrt(np.mean(f**2, axis=1, keepdims=True))
        if not np.all(size > 0):
            raise InputError("design: a parameter has no influence on any candidate")
        old = (
            np.zeros((layers, 0, parameters)) if existing is None else stacked_derivatives(existing)
        )
        allowed = np.any(f != 0, axis=(0, 2))
        places = None if coordinates is None else np.asarray(coordinates, dtype=float)
        if places is not None and existing_coordinates is not None:
            gaps = _distances(places, np.asarray(existing_coordinates, dtype=float))
            allowed &= ~np.any(gaps < max(separation, 1e-9), axis=1)
        prior = np.full(layers, 1 / layers)
        return cls(
            derivatives=f / size,
            prior=prior,
            known=(old / size).transpose(0, 2, 1) @ (old / size),
            scale_log_det=float(prior @ (2 * np.sum(np.log(size[:, 0]), axis=-1))),
            coordinates=places,
            separation=separation,
            allowed=allowed,
        )

    def information(self, chosen: Indices, *, start: float = 0.0) -> Array:
        f = self.derivatives[:, chosen]
        identity = np.eye(f.shape[2])
        return np.asarray(self.known + f.transpose(0, 2, 1) @ f + start * identity)

    def free(self, chosen: Indices) -> NDArray[np.bool_]:
        """Which candidates may join the points chosen."""
        free = self.allowed.copy()
        free[chosen] = False
        if self.coordinates is not None and self.separation > 0 and len(chosen):
            gaps = _distances(self.coordinates, self.coordinates[chosen])
            free &= np.all(gaps >= self.separation * (1 - 1e-9), axis=1)
        return free

    def random(self, count: int, rng: np.random.Generator) -> Indices:
        chosen = np.empty(0, dtype=int)
        for _ in range(count):
            free = np.flatnonzero(self.free(chosen))
            if len(free) == 0:
                break
            chosen = np.append(chosen, rng.choice(free))
        return chosen

    def grown(self, chosen: Indices, points: int) -> Indices:
        """The points chosen and more, each time the one with the largest gain."""
        while len(chosen) < points:
            free = self.free(chosen)
            if not free.any():
                raise InputError(
                    f"design: only {len(chosen)} of {points} points fit in; ask for fewer, a "
                    "smaller separation or more candidates"
                )
            inverse = np.linalg.inv(self.information(chosen, start=START_INFORMATION))
            f = self.derivatives
            variance = np.einsum("kni,kij,knj->kn", f, inverse, f)
            gain = np.where(free, self.prior @ np.log1p(variance), -np.inf)
            chosen = np.append(chosen, np.argmax(gain))
        return chosen

    def improved(self, chosen: Indices) -> ExactDesign:
        """The points exchanged one by one until no exchange helps."""
        f = self.derivatives
        log_det = self._log_det(chosen)
        if not np.isfinite(log_det):
            return ExactDesign(np.sort(chosen), -np.inf)
        for _ in range(100):
            before = log_det
            for place in range(len(chosen)):
                inverse = np.linalg.inv(self.information(chosen))
                turned = f @ inverse
                variance = np.einsum("kni,kni->kn", turned, f)
                mixed = np.einsum("kni,ki->kn", turned, f[:, chosen[place]])
                own = variance[:, chosen[place], None]
                ratio = (1 + variance) * (1 - own) + mixed**2
                gain = self.prior @ np.log(np.maximum(ratio, 1e-300))
                gain = np.where(self.free(np.delete(chosen, place)), gain, -np.inf)
                if gain.max() > 1e-10:
                    chosen = chosen.copy()
                    chosen[place] = int(np.argmax(gain))
            log_det = self._log_det(chosen)
            if log_det <= before + 1e-10:
                break
        return ExactDesign(np.sort(chosen), log_det + self.scale_log_det)

    def _log_det(self, chosen: Indices) -> float:
        matrix = self.information(chosen)
        if np.linalg.cond(matrix).max() > 1e14:
            return -np.inf
        return float(self.prior @ np.linalg.slogdet(matrix)[1])


def _distances(points: Array, others: Array) -> Array:
    return np.asarray(np.linalg.norm(points[:, None] - others[None], axis=-1))
