"""Approximate D-optimal designs, with a certificate: how far any design can be from the best.

An approximate design gives each candidate point x_i a weight w_i >= 0, summing to one; its
information matrix is M = sum w_i f_i f_i', with f_i the derivatives of the response at x_i. Since
log det M is concave in the weights, the best design can be verified (Kiefer and Wolfowitz 1960): a
design is D-optimal if and only if its sensitivity d(x) = f(x)' M^-1 f(x) is nowhere above the
number of parameters p. For any other design it bounds the loss: with M* the best matrix,
tr(M^-1 M*) <= max d, and by the inequality of arithmetic and geometric means
(det M / det M*)^(1/p) >= p / max d.

Weights come from the multiplicative algorithm, w_i <- w_i d_i / p, which raises log det M in every
step (Titterington 1976), with Newton steps between, on the few points that matter.

Uncertain parameters. Derivatives may come as a stack, one layer for each of K parameter vectors:
the criterion is then the mean of log det M_k (Bayesian D), and everything above holds for the
mean of d_k. `maximin_design` makes the least of the K efficiencies large.

Derivatives have shape (n, p) or (K, n, p); rows that are undefined (NaN) carry no information.
Nothing here knows a model, a factor or a unit, and D-optimality does not depend on the parameters'.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import qr, solve_triangular
from scipy.optimize import minimize

from squeezefilm.designs.box import Box
from squeezefilm.errors import InputError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Gradients = Callable[[Array], Array]
"""From points, shape (n, k), to derivatives, shape (n, p) or (K, n, p)."""

DROPPED = 1e-9
"""Weight below which a point is not in the support."""
SINGULAR = 1e-12
"""Diagonal of a triangular factor with columns of length one, below which it is singular."""
ROUNDS, STEPS = 100, 100
SAME_POINT = 2e-3
"""Distance in unit factors within which points of a support are one."""
PEAK_ROUNDS, PEAKS = 20, 8


@dataclass(frozen=True, eq=False)
class ApproximateDesign:
    """Weights over n candidates and what is known of their quality.

    weights, shape (n,), sum to one. log_det, shape (K,), is log det M for each parameter vector, in
    the units of the derivatives. efficiency_bound is a lower bound of the D-efficiency against all
    designs on these candidates; for a maximin design, of its least efficiency over the best
    possible one.
    """

    weights: Array
    log_det: Array
    efficiency_bound: float

    def on(self, candidates: Array) -> ContinuousDesign:
        """The candidates, shape (n, k), that have a weight."""
        support = self.weights > DROPPED
        weights = self.weights[support] / self.weights[support].sum()
        return ContinuousDesign(candidates[support], weights, self.efficiency_bound)


@dataclass(frozen=True, eq=False)
class ContinuousDesign:
    """Points, shape (s, k), weights, shape (s,), and a bound of the D-efficiency from below."""

    points: Array
    weights: Array
    efficiency_bound: float | None = None


def stacked_derivatives(derivatives: ArrayLike) -> Array:
    """Derivatives of shape (n, p) or (K, n, p) as (K, n, p); undefined rows become zero."""
    f = np.asarray(derivatives, dtype=float)
    if f.ndim not in (2, 3):
        raise InputError(f"design: derivatives have shape (n, p) or (K, n, p), not {f.shape}")
    f = f if f.ndim == 3 else f[None]
    return np.where(np.isfinite(f).all(axis=-1, keepdims=True), f, 0.0)


def log_determinant(derivatives: ArrayLike, weights: ArrayLike | None = None) -> Array:
    """log det M, shape (K,), of a design with derivatives (n, p) or (K, n, p).

    Equal weights if left out. Minus infinity where M is singular.
    """
    return np.array([2 * np.sum(np.log(each)) for each in _diagonals(derivatives, weights)])


def sensitivity(
    design: ArrayLike, derivatives: ArrayLike, *, weights: ArrayLike | None = None
) -> Array:
    """Mean of f' M^-1 f / p of a design with derivatives (K, s, p), at others (K, n, p).

    Equal weights if left out. Undefined derivatives give zero. Infinite where M is singular.
    """
    own, other = stacked_derivatives(design), stacked_derivatives(derivatives)
    total = np.zeros(other.shape[1])
    for f, at, diagonal in zip(own, other, _diagonals(design, weights), strict=True):
        if not np.all(diagonal > 0):
            return np.full(other.shape[1], np.inf)
        triangle = np.linalg.qr(_weighted(f, weights), mode="r")
        total += np.sum(solve_triangular(triangle, at.T, trans="T") ** 2, axis=0)
    return np.asarray(total / len(own) / own.shape[2])


def _weighted(f: Array, weights: ArrayLike | None) -> Array:
    share = np.full(len(f), 1 / len(f)) if weights is None else np.asarray(weights)
    return np.sqrt(share)[:, None] * f


def _diagonals(derivatives: ArrayLike, weights: ArrayLike | None) -> Array:
    """Diagonals of the triangular factors of M, shape (K, p); zero where M is singular."""
    stack = stacked_derivatives(derivatives)
    diagonals = np.zeros((len(stack), stack.shape[2]))
    for diagonal, f in zip(diagonals, (_weighted(f, weights) for f in stack), strict=True):
        size = np.linalg.norm(f, axis=0)
        if len(f) >= f.shape[1] and np.all(size > 0):
            scaled = np.abs(np.diagonal(np.linalg.qr(f / size, mode="r")))
            diagonal[:] = np.where(scaled.min() > SINGULAR, scaled * size, 0.0)
    return diagonals


def optimal_weights(
    derivatives: ArrayLike, *, prior: ArrayLike | None = None, gap: float = 1e-6
) -> ApproximateDesign:
    """The D-optimal weights of n candidates, to an efficiency of 1 - gap.

    The candidates of largest sensitivity join a small active set, whose weights are made optimal,
    until the equivalence theorem holds for all.

    derivatives are those of the candidates, shape (n, p) or (K, n, p); prior, shape (K,), are the
    weights of the parameter vectors, equal if left out.
    Raises InputError where the candidates cannot tell the parameters apart.
    """
    f, scale = _scaled(derivatives)
    layers, points, parameters = f.shape
    share = np.full(layers, 1 / layers) if prior is None else np.asarray(prior)
    # p points of large determinant for each parameter vector: pivots of a QR decomposition.
    picks = [qr(layer.T, mode="r", pivoting=True)[1][:parameters] for layer in f]
    weights = np.zeros(points)
    weights[np.unique(np.concatenate(picks))] = 1.0
    for _ in range(ROUNDS):
        weights /= weights.sum()
        active = np.flatnonzero(weights)
        weights[active] = _best_weights(f[:, active], weights[active], share, gap=gap / 4)
        weights[weights < DROPPED] = 0
        weights /= weights.sum()
        level = share @ _variances(f, weights) / parameters
        if level.max() <= 1 + gap:
            break
        weights[np.argpartition(level, -parameters)[-parameters:]] += 1e-2
    log_det = np.linalg.slogdet(_information(f, weights))[1] - scale
    return ApproximateDesign(weights, log_det, float(min(1.0, 1 / level.max())))


def maximin_design(derivatives: ArrayLike) -> ApproximateDesign:
    """Weights with the largest least D-efficiency over K parameter vectors.

    derivatives has shape (K, n, p). Efficiency k is (det M_k / det M_k*)^(1/p) against the best
    design for vector k alone. The maximin design is Bayesian for the least favourable prior, the
    one whose best mean log efficiency is least: a convex function of the prior, whose slopes are
    the log efficiencies. That mean bounds what any design can have.
    """
    stack = stacked_derivatives(derivatives)
    layers, parameters = len(stack), stack.shape[2]
    goal = np.array([float(optimal_weights(layer, gap=1e-7).log_det[0]) for layer in stack])
    best, ceiling = optimal_weights(stack), 0.0
    least = -np.inf

    def mean_log_efficiency(prior: Array) -> tuple[float, Array]:
        nonlocal best, ceiling, least
        prior = np.maximum(prior, 0) / np.maximum(prior, 0).sum()
        design = optimal_weights(stack, prior=prior, gap=1e-8)
        logs = (design.log_det - goal) / parameters
        if logs.min() > least:
            best, least = design, float(logs.min())
        ceiling = min(ceiling, float(prior @ logs) - np.log(design.efficiency_bound))
        return float(prior @ logs), logs

    minimize(
        mean_log_efficiency,
        np.full(layers, 1 / layers),
        jac=True,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * layers,
        constraints={"type": "eq", "fun": lambda z: z.sum() - 1, "jac": np.ones_like},
        options={"ftol": 1e-12, "maxiter": 200},
    )
    return replace(best, efficiency_bound=float(min(1.0, np.exp(least - ceiling))))


def _scaled(derivatives: ArrayLike) -> tuple[Array, Array]:
    """Derivatives (K, n, p) in parameters for which the plain mean is M = I, and log det of these.

    Raises InputError where they cannot tell the parameters apart.
    """
    f = stacked_derivatives(derivatives)
    scale = np.empty((len(f), f.shape[2], f.shape[2]))
    for layer, each in zip(scale, f, strict=True):
        columns = np.linalg.norm(each, axis=0)
        if len(each) < f.shape[2] or not np.all(columns > 0):
            raise InputError("design: a parameter has no influence on any candidate")
        triangle = np.linalg.qr(each / columns, mode="r")
        if np.abs(np.diagonal(triangle)).min() < 1e-13:
            raise InputError("design: the candidates cannot tell the parameters apart")
        layer[:] = np.linalg.inv(triangle) / columns[:, None] * np.sqrt(len(each))
    return f @ scale, np.asarray(2 * np.linalg.slogdet(scale)[1], dtype=float)


def _information(f: Array, weights: Array) -> Array:
    used = np.flatnonzero(weights)
    return np.asarray(f[:, used].transpose(0, 2, 1) * weights[used] @ f[:, used])


def _variances(f: Array, weights: Array) -> Array:
    """d_k(x) of every candidate, shape (K, n)."""
    return np.einsum("kni,kni->kn", f @ np.linalg.inv(_information(f, weights)), f)


def _best_weights(f: Array, weights: Array, prior: Array, *, gap: float) -> Array:
    """The best weights of a few points: multiplicative steps, each followed by a Newton step."""
    for _ in range(STEPS):
        level = prior @ _variances(f, weights) / f.shape[2]
        if level.max() <= 1 + gap:
            break
        weights = _newton_step(f, weights * level, prior)
    return weights


def _newton_step(f: Array, weights: Array, prior: Array) -> Array:
    """Newton's step for the weights, as far as it raises log det M and none is negative."""
    used = np.flatnonzero(weights > DROPPED / 100)
    part = f[:, used]
    cross = part @ np.linalg.inv(_information(f, weights)) @ part.transpose(0, 2, 1)
    slope = prior @ np.diagonal(cross, axis1=1, axis2=2)
    one = np.ones((len(used), 1))
    matrix = np.block([[np.einsum("k,kij->ij", prior, cross**2), one], [one.T, 0.0]])
    change = np.linalg.lstsq(matrix, np.append(slope, 0.0), rcond=1e-12)[0][:-1]
    change -= change.mean()
    shrinking = change < 0
    limit = float(np.min(-weights[used][shrinking] / change[shrinking], initial=1.0))
    before = prior @ np.linalg.slogdet(_information(f, weights))[1]
    for step in limit * 0.5 ** np.arange(8):
        moved = np.zeros(len(weights))
        moved[used] = np.maximum(weights[used] + step * change, 0)
        moved /= moved.sum()
        if prior @ np.linalg.slogdet(_information(f, moved))[1] > before:
            return moved
    return weights


def optimal_in_box(
    gradients: Gradients, box: Box, candidates: Array, *, gap: float = 1e-10
) -> ContinuousDesign:
    """The best approximate design anywhere in the box, from a grid of candidates, shape (n, k).

    The support of the best design on the grid is moved off it together with its weights, and peaks
    of the sensitivity join it, until the equivalence theorem holds at every peak. efficiency_bound
    holds against the grid and all peaks between its points. Raises InputError where the candidates
    cannot tell the parameters apart.
    """
    grid = gradients(candidates)
    points = _merged(candidates, optimal_weights(grid).weights, box)
    best, highest = ContinuousDesign(points[:0], np.empty(0)), 0.0
    for _ in range(PEAK_ROUNDS):
        points = _moved(points, optimal_weights(gradients(points)).weights, gradients, box)
        points = _merged(points, optimal_weights(gradients(points)).weights, box)
        own = gradients(points)
        weights = optimal_weights(own, gap=gap / 10).weights
        level = sensitivity(own, grid, weights=weights)
        starts = np.concatenate([points, candidates[np.argsort(level)[-PEAKS:]]])
        peaks = _climbed(own, weights, gradients, box, starts)
        there = sensitivity(own, gradients(peaks), weights=weights)
        bound = float(min(1.0, 1 / max(level.max(), there.max())))
        if bound > highest:
            used, highest = weights > DROPPED, bound
            best = ContinuousDesign(points[used], weights[used] / weights[used].sum(), bound)
        if bound >= 1 - gap:
            break
        higher = there > 1 + gap
        heights = np.append(1 + weights, np.where(higher, 1e-3 * there, 0))
        points = _merged(np.concatenate([points, peaks]), heights, box)
    return best


def _moved(points: Array, weights: Array, gradients: Gradients, box: Box) -> Array:
    """The points of a design moved, and its weights with them, to where log det M is largest.

    Its slope is w_i times that of d at a point x_i, and d_i - p with respect to a weight.
    """
    count, factors = points.shape
    shift = 1e-6 * np.eye(factors)

    def loss(z: Array) -> tuple[float, Array]:
        unit, weight = z[:-count].reshape(points.shape), z[-count:]
        share, own = weight / weight.sum(), gradients(box.from_unit(unit))
        above, below = (np.clip(unit[:, None] + sign * shift, 0, 1) for sign in (1, -1))
        near = np.concatenate([above, below]).reshape(-1, factors)
        level = sensitivity(own, gradients(box.from_unit(near)), weights=share)
        rise = np.subtract(*level.reshape(2, count, factors)) / (above - below).sum(axis=-1)
        at = sensitivity(own, own, weights=share)
        slopes = np.append(share[:, None] * rise, (at - 1) / weight.sum())
        return -float(log_determinant(own, share).mean()) / own.shape[-1], -slopes

    found = minimize(
        loss,
        np.append(box.to_unit(points), weights),
        jac=True,
        method="L-BFGS-B",
        bounds=[(0.0, 1.0)] * (count * factors) + [(1e-12, 1.0)] * count,
        options={"ftol": 1e-15, "gtol": 1e-9},
    )
    return box.from_unit(found.x[:-count].reshape(points.shape))


def _climbed(own: Array, weights: Array, gradients: Gradients, box: Box, starts: Array) -> Array:
    """The maxima of a design's sensitivity next to points, shape (n, k)."""

    def height(unit: Array) -> float:
        at = gradients(box.from_unit(unit[None]))
        return -float(sensitivity(own, at, weights=weights)[0])

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
    """The points with a weight, of those closer than SAME_POINT the heaviest."""
    kept: list[Array] = []
    for place in np.argsort(-weights)[: np.count_nonzero(weights > DROPPED)]:
        unit = box.to_unit(points[place])
        if all(np.linalg.norm(unit - other) > SAME_POINT for other in kept):
            kept.append(unit)
    return box.from_unit(np.array(kept))
