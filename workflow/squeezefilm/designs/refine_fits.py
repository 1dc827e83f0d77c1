"""The points that the refine loop knows of, and fits to those of them that are simulated."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from squeezefilm.models.data import Factors
from squeezefilm.models.fitting import fit_model, local_fit, sum_of_squares
from squeezefilm.models.force_model import ExpressionModel

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Pool:
    """All points the loop knows of: their factors, shape (n,), and coordinates, shape (n, c).

    candidates may be simulated and fitted, verification are simulated and not fitted, typical are
    a fair sample of the space of which nothing is simulated; each is a set of indices. Distances
    are taken between coordinates, scaled so that the space is about one wide.
    """

    factors: Factors
    coordinates: Array
    candidates: Indices
    verification: Indices
    typical: Indices


class Fits:
    """Forces of the pool's points in newtons, NaN where none is known, and fits to some of them.

    bound and seed are those of the global search with which a fit begins where none is known.
    """

    def __init__(self, model: ExpressionModel, pool: Pool, *, bound: float, seed: int) -> None:
        self.model, self.pool, self.bound, self.seed = model, pool, bound, seed
        self.force_n = np.full(len(pool.factors), np.nan)
        self.error_n = np.full(len(pool.factors), np.nan)

    def add(self, points: Indices, force_n: Array, error_n: Array) -> None:
        """The forces of more points and the errors of these, in newtons."""
        self.force_n[points], self.error_n[points] = force_n, error_n

    def fitted(self, points: Indices, start: Array | None) -> Array:
        """Parameters by least squares on some points: a global search, or near a start."""
        if not self.model.parameter_names:
            return np.empty(0)
        factors, force = self.pool.factors.take(points), self.force_n[points]
        if start is None or sum_of_squares(self.model, factors, force, start) == np.inf:
            found = fit_model(self.model, factors, force, bound=self.bound, seed=self.seed)
            start = np.array(found.theta)
        return local_fit(self.model, factors, force, start)

    def residuals(self, theta: Array, points: Indices) -> Array:
        return self.model.evaluate(theta, self.pool.factors.take(points)) - self.force_n[points]

    def variances(self, theta: Array, design: Indices, points: Indices) -> Array:
        """f'(F'F)^-1 f at points, F being that of the design; infinite where it is singular."""
        if not len(theta):
            return np.zeros(len(points))
        f = self.model.gradient(theta, self.pool.factors.take(design))
        at = self.model.gradient(theta, self.pool.factors.take(points))
        size = np.linalg.norm(f, axis=0)
        if not np.all(np.isfinite(size) & (size > 0)):
            return np.full(len(points), np.inf)
        triangle: Array = np.asarray(np.linalg.qr(f / size, mode="r"))
        if len(design) < len(theta) or np.abs(np.diagonal(triangle)).min() < 1e-10:
            return np.full(len(points), np.inf)
        rows = np.linalg.solve(triangle.T, np.nan_to_num(at / size).T)
        return np.where(np.isfinite(at).all(axis=1), np.sum(rows**2, axis=0), np.inf)

    def best_of(self, points: Indices, starts: Sequence[Array | None]) -> Array:
        """The least-squares fit to points from several starts, None being a global search."""
        factors, force = self.pool.factors.take(points), self.force_n[points]
        fits = [self.fitted(points, start) for start in starts]
        return min(fits, key=lambda theta: sum_of_squares(self.model, factors, force, theta))

    def scale(self, theta: Array) -> float:
        """Root mean square force over the space, by the model."""
        force = self.model.evaluate(theta, self.pool.factors.take(self.pool.typical))
        known = force[np.isfinite(force)]
        return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")
