"""Approximate D-optimal designs anywhere in a box, not only on a grid of candidates.

The optimum on a grid is taken, every point of it and every peak of the sensitivity is moved to
the nearest maximum off the grid, and the optimum is sought again with these points among the
candidates, until the equivalence theorem holds at every peak.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import minimize

from squeezefilm.designs.box import Box
from squeezefilm.designs.optimal_design import optimal_weights, stacked_derivatives

Array = NDArray[np.float64]
Gradients = Callable[[Array], Array]
"""From points, shape (n, k), to derivatives, shape (n, p) or (K, n, p)."""

SAME_POINT = 2e-3
"""Distance in unit factors within which points of a support are one."""
ROUNDS = 8


@dataclass(frozen=True, eq=False)
class ContinuousDesign:
    """Points, shape (s, k), their weights, shape (s,), and a bound of the D-efficiency from below.

    derivatives, shape (K, s, p), are those of the points.
    """

    points: Array
    weights: Array
    derivatives: Array
    efficiency_bound: float

    def sensitivity(self, derivatives: ArrayLike) -> Array:
        """d(x)/p at points with these derivatives, shape (n, p) or (K, n, p); one at most."""
        return sensitivity(self.derivatives, derivatives, weights=self.weights)


def sensitivity(
    design: ArrayLike, derivatives: ArrayLike, *, weights: ArrayLike | None = None
) -> Array:
    """Mean of f' M^-1 f / p of a design with derivatives (K, s, p), at others (K, n, p).

    Equal weights if left out. Undefined derivatives give zero.
    """
    own, other = stacked_derivatives(design), stacked_derivatives(derivatives)
    share = np.full(own.shape[1], 1 / own.shape[1]) if weights is None else np.asarray(weights)
    total = np.zeros(other.shape[1])
    for f, at in zip(own, other, strict=True):
        triangle = np.linalg.qr(np.sqrt(share)[:, None] * f, mode="r")
        total += np.sum(solve_triangular(triangle, at.T, trans="T") ** 2, axis=0) / len(own)
    return np.asarray(total / own.shape[2])


def optimal_in_box(
    gradients: Gradients,
    box: Box,
    candidates: Array,
    *,
    gap: float = 1e-10,
) -> ContinuousDesign:
    """The best approximate design in the box, from a grid of candidates, shape (n, k).

    efficiency_bound holds against all candidates and all peaks of the sensitivity that were found
    between them. Raises InputError where the candidates cannot tell the parameters apart.
    """
    grid, extra = stacked_derivatives(gradients(candidates)), np.empty((0, candidates.shape[1]))
    found: list[ContinuousDesign] = []
    for _ in range(ROUNDS):
        points = np.concatenate([candidates, extra])
        derivatives = np.concatenate([grid, stacked_derivatives(gradients(extra))], axis=1)
        there = optimal_weights(derivatives, gap=gap / 10)
        rough = _weighted(points[there.support], there.weights[there.support], gradients, box)
        moved = _climbed(rough, gradients, box, rough.points)
        design = _weighted(moved, np.ones(len(moved)), gradients, box)
        level = design.sensitivity(derivatives)
        highest_few = points[np.argsort(level)[-8:]]
        starts = np.unique(np.concatenate([design.points, highest_few]), axis=0)
        peaks = _climbed(design, gradients, box, starts)
        highest = max(level.max(), float(design.sensitivity(gradients(peaks)).max()))
        found.append(replace(design, efficiency_bound=float(min(1.0, 1 / highest))))
        if found[-1].efficiency_bound >= 1 - gap:
            break
        extra = np.unique(np.concatenate([rough.points, design.points, peaks]), axis=0)
    return max(found, key=lambda design: design.efficiency_bound)


def _weighted(points: Array, weights: Array, gradients: Gradients, box: Box) -> ContinuousDesign:
    """The best weights for these points, once those that lie together are one."""
    points = _merged(points, weights, box)
    derivatives = stacked_derivatives(gradients(points))
    found = optimal_weights(derivatives, gap=1e-12)
    used = found.support
    return ContinuousDesign(
        points=points[used],
        weights=found.weights[used] / found.weights[used].sum(),
        derivatives=derivatives[:, used],
        efficiency_bound=0.0,
    )


def _climbed(design: ContinuousDesign, gradients: Gradients, box: Box, starts: Array) -> Array:
    """The maxima of the sensitivity next to points, shape (n, k)."""

    def height(unit: Array) -> float:
        return -float(design.sensitivity(gradients(box.from_unit(unit[None])))[0])

    tops = []
    for unit in np.clip(box.to_unit(starts), 0, 1):
        top = minimize(
            height,
            unit,
            method="L-BFGS-B",
            jac="3-point",
            bounds=[(0.0, 1.0)] * len(unit),
            options={"ftol": 1e-15, "gtol": 1e-9},
        )
        tops.append(top.x if top.fun < height(unit) else unit)
    return box.from_unit(np.array(tops))


def _merged(points: Array, weights: Array, box: Box) -> Array:
    """Points with those closer than SAME_POINT drawn together to their weighted mean."""
    unit = box.to_unit(points)
    kept: list[tuple[Array, float]] = []
    for place, weight in sorted(zip(unit, weights, strict=True), key=lambda pair: -pair[1]):
        for index, (other, heavy) in enumerate(kept):
            if np.linalg.norm(place - other) <= SAME_POINT:
                total = heavy + weight
                kept[index] = ((other * heavy + place * weight) / total, total)
                break
        else:
            kept.append((place, weight))
    return box.from_unit(np.array([place for place, _ in kept]))
