"""Approximate D-optimal designs, with a certificate: how far any design can be from the best.

An approximate design gives each candidate point x_i a weight w_i >= 0, summing to one; its
information matrix is M = sum w_i f_i f_i', with f_i the derivatives of the response at x_i.

Since log det M is concave in the weights, the best design can be verified (Kiefer and Wolfowitz
1960): a design is D-optimal if and only if its sensitivity d(x) = f(x)' M^-1 f(x) is nowhere above
the number of parameters p. For any other design it bounds the loss: with M* the best matrix,
tr(M^-1 M*) <= max d, and by the inequality of arithmetic and geometric means (det M / det M*)^(1/p)
>= p / max d.

Weights come from an interior-point method on the few points that matter (Lu and Pong 2013); points
of large sensitivity join them.

Uncertain parameters. Derivatives may come as a stack, one layer for each of K parameter vectors:
the criterion is then the mean of log det M_k (Bayesian D), and everything above holds for the
mean of d_k. `maximin_design` makes the least of the K efficiencies large.

Derivatives have shape (n, p) or (K, n, p); rows that are undefined (NaN) carry no information.
Nothing here knows a model, a factor or a unit, and D-optimality does not depend on the parameters'.

An exact design has so many points, each of them once: a simulation has no scatter, so a second one
at the same point teaches nothing, and one close by hardly anything. It is sought by exchange
(Fedorov 1972), one point at a time, and is the best found from EXCHANGE_START_COUNT starts: the
exchange ends in local maxima, and no certificate holds for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import qr
from scipy.optimize import minimize
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist
from scipy.stats import qmc

from squeezefilm.designs.space import Array, Space, pair_distances
from squeezefilm.errors import InputError

Indices = NDArray[np.int64]
GradientFunction = Callable[[Array], Array]
"""From points, shape (n, k), to derivatives, shape (n, p) or (K, n, p)."""

MIN_SUPPORT_WEIGHT = 1e-6
"""Weight below which a point is no experiment: what the iteration leaves."""
SINGULAR_DIAGONAL_TOLERANCE = 1e-12
"""Diagonal of a triangular factor with columns of length one, below which it is singular."""
MAX_ACTIVE_SET_ROUNDS, MAX_INTERIOR_POINT_STEPS = 100, 100
UNIFORM_START_FRACTION, CENTRING_PARAMETER, BOUNDARY_STEP_FRACTION = 0.1, 0.1, 0.95
"""Of the interior-point method: equal weights in the start, μ over the last one, and the part of
the way to where a weight or a slack is zero."""
COMPLEMENTARITY_TOLERANCE, MIN_ACTIVE_WEIGHT = 1e-14, 1e-12
"""Slack that is left, relative, and the weight that stands for none in further rounds."""
SAME_DERIVATIVES_DISTANCE = 5e-3
"""Relative distance of derivatives within which points of a support are one."""
SAME_POINT_DISTANCE = 0.1
"""In the unit cube, within which the mean of such points is taken."""
JUMP_DISTANCE = 1e-6
"""In the unit cube, within which derivatives that differ have a jump in between."""
MAX_PEAK_ROUNDS = 20
SAMPLE_SIZE_OF_ONE_FACTOR = 512
"""Points at which the sensitivity is looked at besides the candidates; twice as many for each
further factor."""
MIN_CLIMB_START_SENSITIVITY = 0.8
"""Of a point from which a peak above one may be near."""
MAX_CLIMB_STEPS, MIN_CLIMB_STEP = 300, 1e-8
EXCHANGE_START_COUNT = 50
"""Of an exchange, from different points."""
REGULARISATION_FRACTION = 1e-6
"""Information of an exchange at its start, as a share of the candidates' mean: M is never singular.
"""


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
        support = self.weights > MIN_SUPPORT_WEIGHT
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
    f = f if f.ndim == 3 else f[None]
    return np.where(np.isfinite(f).all(axis=-1, keepdims=True), f, 0.0)


def log_determinant(derivatives: ArrayLike, weights: ArrayLike | None = None) -> Array:
    """log det M, shape (K,), of a design with derivatives (n, p) or (K, n, p).

    Equal weights by default. Minus infinity where M is singular.
    """
    pivots = np.diagonal(
        _information_cholesky(stacked_derivatives(derivatives), weights), axis1=1, axis2=2
    )
    with np.errstate(divide="ignore"):
        return np.asarray(2 * np.log(np.abs(pivots)).sum(axis=1))


def sensitivity(
    design: ArrayLike, derivatives: ArrayLike, *, weights: ArrayLike | None = None
) -> Array:
    """Mean of f' M^-1 f / p of a design with derivatives (K, s, p), at others (K, n, p).

    Equal weights by default. Undefined derivatives give zero. Infinite where M is singular.
    """
    roots = _information_cholesky(stacked_derivatives(design), weights)
    other = stacked_derivatives(derivatives)
    if not roots.any(axis=(1, 2)).all():
        return np.full(other.shape[1], np.inf)
    return np.asarray(_prediction_variances(other, roots).mean(axis=0) / other.shape[2])


def _information_cholesky(f: Array, weights: ArrayLike | None = None) -> Array:
    """Triangular factors R of M = RᵀR, shape (K, p, p); zero where M is singular."""
    layers, points, parameters = f.shape
    if points < parameters:
        return np.zeros((layers, parameters, parameters))
    design_weights = np.full(points, 1 / points) if weights is None else np.asarray(weights)
    roots = np.linalg.qr(np.sqrt(design_weights)[:, None] * f, mode="r")
    pivots = np.abs(np.diagonal(roots, axis1=1, axis2=2))
    singular = np.any(pivots <= SINGULAR_DIAGONAL_TOLERANCE * np.linalg.norm(roots, axis=1), axis=1)
    return np.where(singular[:, None, None], 0.0, roots)


def _prediction_variances(f: Array, roots: Array) -> Array:
    """Variance functions f'M⁻¹f of every candidate, shape (K, n)."""
    return np.sum((f @ np.linalg.inv(roots)) ** 2, axis=-1)


def optimal_approximate_design(
    derivatives: ArrayLike, *, prior: ArrayLike | None = None, gap: float = 1e-6
) -> ApproximateDesign:
    """The D-optimal weights of n candidates, to an efficiency of 1 - gap.

    The candidates of largest sensitivity join a small active set, whose weights are made optimal,
    until the equivalence theorem holds for all.

    derivatives are those of the candidates, shape (n, p) or (K, n, p); prior, shape (K,), are the
    weights of the parameter vectors, equal by default.
    Raises InputError where the candidates cannot tell the parameters apart.
    """
    f = stacked_derivatives(derivatives)
    layers, points, parameters = f.shape
    prior_weights = np.full(layers, 1 / layers) if prior is None else np.asarray(prior)
    roots, scale = _information_cholesky(f), log_determinant(f)
    if not np.isfinite(scale).all():
        raise InputError("design: the candidates cannot tell the parameters apart")
    f = f @ np.linalg.inv(roots)  # parameters in which M of equal weights is the identity
    # p points of large determinant for each parameter vector: pivots of a QR decomposition.
    picks = [qr(layer.T, mode="r", pivoting=True)[1][:parameters] for layer in f]
    weights = np.zeros(points)
    weights[np.unique(np.concatenate(picks))] = 1.0
    for _ in range(MAX_ACTIVE_SET_ROUNDS):
        active = np.flatnonzero(weights)
        best = _interior_point_weights(
            f[:, active], weights[active] / weights.sum(), prior_weights, gap=gap / 4
        )
        weights[active] = np.where(best < MIN_ACTIVE_WEIGHT, 0, best)
        weights /= weights.sum()
        roots = _information_cholesky(f[:, active], weights[active])
        level = prior_weights @ _prediction_variances(f, roots) / parameters
        if level.max() <= 1 + gap:
            break
        weights[np.argpartition(level, -parameters)[-parameters:]] += 1e-2
    log_det = log_determinant(f[:, active], weights[active]) + scale
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
    goal = np.array(
        [float(optimal_approximate_design(layer, gap=1e-7).log_det[0]) for layer in stack]
    )
    best, least, ceiling = optimal_approximate_design(stack), -np.inf, 0.0

    def mean_log_efficiency(prior: Array) -> tuple[float, Array]:
        nonlocal best, ceiling, least
        prior = np.maximum(prior, 0) / np.maximum(prior, 0).sum()
        design = optimal_approximate_design(stack, prior=prior, gap=1e-8)
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


def _interior_point_weights(f: Array, weights: Array, prior: Array, *, gap: float) -> Array:
    """The best weights of a few points, by a primal-dual interior-point method.

    Optimal are weights w with slacks z ≥ 0 of the equivalence theorem, d + z = λ and w z = 0; the
    method follows w z = μ to μ → 0. As Σ w d = p, what is left is λ/p − 1 = Σ w z/p.
    """
    parameters = f.shape[2]
    weights = (1 - UNIFORM_START_FRACTION) * weights + UNIFORM_START_FRACTION / len(weights)
    variances = prior @ _prediction_variances(f, _information_cholesky(f, weights))
    ceiling = (1 + UNIFORM_START_FRACTION) * variances.max()
    slack = ceiling - variances
    for _ in range(MAX_INTERIOR_POINT_STEPS):
        part = f @ np.linalg.inv(_information_cholesky(f, weights))
        cross = part @ part.transpose(0, 2, 1)
        variances = prior @ np.diagonal(cross, axis1=1, axis2=2)
        left = float(weights @ slack)
        if (
            variances.max() <= (1 + gap) * parameters
            and left <= COMPLEMENTARITY_TOLERANCE * parameters
        ):
            break
        centred = CENTRING_PARAMETER * left / len(weights)
        matrix = np.einsum("k,kij->ij", prior, cross**2) + np.diag(slack / weights)
        sides = np.stack([variances - ceiling + centred / weights, np.ones(len(weights))], axis=1)
        change, per_ceiling = np.linalg.solve(matrix, sides).T
        ceiling_change = change.sum() / per_ceiling.sum()
        change -= ceiling_change * per_ceiling
        slack_change = (centred - slack * change) / weights - slack
        fall = max(np.max(-change / weights), np.max(-slack_change / slack))
        step = min(1.0, BOUNDARY_STEP_FRACTION / fall) if fall > 0 else 1.0
        weights, slack = weights + step * change, slack + step * slack_change
        weights, ceiling = weights / weights.sum(), ceiling + step * ceiling_change
    return weights


def optimal_design_in_space(
    gradients: GradientFunction, space: Space, candidates: Array, *, gap: float = 1e-10
) -> ContinuousDesign:
    """The best approximate design anywhere in the space, from a grid of candidates, shape (n, k).

    Peaks of the sensitivity join the candidates, until the equivalence theorem holds at every peak
    that is found. efficiency_bound holds against the grid, a Sobol' sequence of other points, and
    the peaks next to both. Where the derivatives jump, as with the direction of a pad at the
    centre, the best points lie on both sides of the jump, one experiment for which the model has
    two values: then the design is the best on the grid, with a bound against the grid alone.

    Raises InputError where the candidates cannot tell the parameters apart.
    """
    points_tried, known = candidates, stacked_derivatives(gradients(candidates))
    best, highest = ContinuousDesign(candidates[:0], np.empty(0)), 0.0
    factors = candidates.shape[1]
    sample_size = SAMPLE_SIZE_OF_ONE_FACTOR * 2 ** (factors - 1)
    for number in range(MAX_PEAK_ROUNDS):
        unit = np.clip(space.to_unit(points_tried), 0, 1)
        merged = _merged_support_points(
            known, unit, optimal_approximate_design(known, gap=gap / 10).weights
        )
        if pair_distances(merged).min(initial=1.0) < JUMP_DISTANCE:
            on_grid = known[:, : len(candidates)]
            return optimal_approximate_design(on_grid, gap=gap / 10).on(candidates)
        points = space.from_unit(merged)
        own = stacked_derivatives(gradients(points))
        design = optimal_approximate_design(own, gap=gap / 10)
        weights = design.weights

        def sensitivity_at(unit: Array, own: Array = own, weights: Array = weights) -> Array:
            there = gradients(space.from_unit(unit.reshape(-1, factors)))
            return sensitivity(own, there, weights=weights).reshape(unit.shape[:-1])

        level = sensitivity(own, known, weights=weights)
        # Other points each round: what one sample misses the next may meet.
        sample = qmc.Sobol(factors, rng=number).random(sample_size)
        looked_at = np.concatenate([unit, sample])
        heights = np.concatenate([level, sensitivity_at(sample)])
        starts = looked_at[_local_maximum_indices(looked_at, heights)]
        peaks = _climb_to_maxima(sensitivity_at, starts, step=sample_size ** (-1 / factors))
        peak_heights = sensitivity_at(peaks)
        bound = float(1 / max(1.0, heights.max(), peak_heights.max()))
        if bound > highest:
            best, highest = replace(design, efficiency_bound=bound).on(points), bound
        if bound >= 1 - gap:
            break
        # Several climbs end on one peak; of a design that is nearly best all its points are peaks.
        higher = peaks[peak_heights > 1 + gap / 2].round(-round(math.log10(MIN_CLIMB_STEP)))
        peaks = space.from_unit(np.unique(higher, axis=0))
        points_tried = np.concatenate([points_tried, peaks])
        known = np.concatenate([known, stacked_derivatives(gradients(peaks))], axis=1)
    return best


def _local_maximum_indices(unit: Array, heights: Array) -> Indices:
    """The points, shape (n, k), that none of their neighbours exceeds, of those worth a climb."""
    _, neighbours = cKDTree(unit).query(unit, k=2 * unit.shape[1] + 1)
    highest = heights[neighbours].max(axis=1) <= heights * (1 + 1e-12)
    return np.flatnonzero(highest & (heights >= MIN_CLIMB_START_SENSITIVITY))


def _climb_to_maxima(height_at: Callable[[Array], Array], starts: Array, *, step: float) -> Array:
    """The maxima next to points of the unit cube, shape (n, k).

    Each point tries a step along either direction of each factor, and its last move again, and
    halves the step where none is higher (Hooke and Jeeves 1961): none leaves the hill it is on, as
    line searches do.
    """
    factors = starts.shape[1]
    directions = np.concatenate([np.eye(factors), -np.eye(factors)])
    ends, rows = starts.copy(), np.arange(len(starts))  # rows that still climb
    at, height, steps = starts, height_at(starts), np.full(len(starts), step)
    last_move = np.zeros_like(at)
    for _ in range(MAX_CLIMB_STEPS):
        moves = steps[:, None, None] * directions
        tried = at[:, None] + np.concatenate([moves, last_move[:, None]], axis=1)
        tried = np.clip(tried, 0, 1)
        heights = height_at(tried)
        best = heights.argmax(axis=1)
        moved = np.take_along_axis(tried, best[:, None, None], axis=1)[:, 0]
        higher = heights.max(axis=1) > height
        last_move = np.where(higher[:, None], moved - at, 0.0)
        at = np.where(higher[:, None], moved, at)
        height = np.where(higher, heights.max(axis=1), height)
        steps = np.where(higher, steps, steps / 2)
        ends[rows], climbing = at, steps >= MIN_CLIMB_STEP
        if not climbing.any():
            break
        rows, at, height = rows[climbing], at[climbing], height[climbing]
        steps, last_move = steps[climbing], last_move[climbing]
    return ends


def _merged_support_points(f: Array, unit: Array, weights: Array) -> Array:
    """The points with a weight, shape (s, k), those of nearly equal derivatives as one.

    It lies at the weighted mean of those near the heaviest: the best point is between them.
    """
    used = np.argsort(-weights)[: np.count_nonzero(weights > MIN_SUPPORT_WEIGHT)]
    rows = np.concatenate(
        f[:, used] @ np.linalg.inv(_information_cholesky(f[:, used], weights[used])), axis=1
    )
    alike = cdist(rows, rows) <= SAME_DERIVATIVES_DISTANCE * np.sqrt(rows.shape[1])
    near = cdist(unit[used], unit[used]) <= SAME_POINT_DISTANCE
    left, merged = np.ones(len(used), dtype=bool), []
    for heaviest in range(len(used)):
        if left[heaviest]:
            group = alike[heaviest] & near[heaviest] & left
            merged.append(np.average(unit[used[group]], axis=0, weights=weights[used[group]]))
            left &= ~alike[heaviest]
    return np.array(merged)


def exact_design_by_exchange(
    derivatives: ArrayLike,
    points: int,
    *,
    existing: ArrayLike | None = None,
    coordinates: ArrayLike | None = None,
    existing_coordinates: ArrayLike | None = None,
    separation: float = 0.0,
    starts: int = EXCHANGE_START_COUNT,
    seed: int = 1,
) -> Indices:
    """The best exact design found among candidates, by exchange from several starts.

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
    if not np.all(size > 0):
        raise InputError("design: a parameter has no influence on any candidate")
    old = f[:, :0] if existing is None else stacked_derivatives(existing)
    known, f = _information_matrices(old / size), f / size
    positions = np.zeros((f.shape[1], 0)) if coordinates is None else np.asarray(coordinates)
    allowed = np.any(f != 0, axis=(0, 2))
    if existing_coordinates is not None:
        near = cdist(positions, np.asarray(existing_coordinates))
        allowed &= ~np.any(near < max(separation, 1e-9), axis=1)

    def admissible_candidates(chosen: Indices) -> Indices:
        """The candidates that may join the points chosen."""
        far = np.all(cdist(positions, positions[chosen]) >= separation * (1 - 1e-9), axis=1)
        far[chosen] = False
        return np.flatnonzero(allowed & far)

    def add_best_points(chosen: Indices) -> Indices:
        """The points chosen and more that fit in, each time the one with the largest gain."""
        while len(chosen) < points and len(open_to := admissible_candidates(chosen)):
            matrix = (
                known
                + _information_matrices(f[:, chosen])
                + REGULARISATION_FRACTION * np.eye(f.shape[2])
            )
            others = f[:, open_to]
            gain = np.log1p(np.einsum("kni,kni->kn", others @ np.linalg.inv(matrix), others))
            chosen = np.append(chosen, open_to[np.argmax(gain.mean(axis=0))])
        return chosen

    def mean_log_determinant(chosen: Indices) -> float:
        """Mean log det of the information; minus infinity where it is singular."""
        matrix = known + _information_matrices(f[:, chosen])
        if np.linalg.cond(matrix).max() > 1e14:
            return -np.inf
        return float(np.linalg.slogdet(matrix)[1].mean())

    rng = np.random.default_rng(seed)
    best, highest, most = np.empty(0, dtype=int), -np.inf, 0
    for start in range(starts):
        # The first start is greedy from nothing, the others from one or more random points.
        chosen = np.empty(0, dtype=int)
        for _ in range(min(start, points)):
            if len(open_to := admissible_candidates(chosen)):
                chosen = np.append(chosen, rng.choice(open_to))
        chosen = add_best_points(chosen)
        most = max(most, len(chosen))
        if len(chosen) < points:
            continue  # these points leave no room for as many
        value, tried = mean_log_determinant(chosen), 0
        while tried < points:
            other = add_best_points(chosen[1:])  # the first point for the best one
            tried = 0 if mean_log_determinant(other) > value + 1e-10 else tried + 1
            value, chosen = (
                (mean_log_determinant(other), other) if tried == 0 else (value, np.roll(chosen, -1))
            )
        if value > highest:
            best, highest = np.sort(chosen), value
    if most < points:
        raise InputError(
            f"design: only {most} of {points} points fit in; ask for fewer, a smaller separation "
            "or more candidates"
        )
    if not np.isfinite(highest):
        raise InputError("design: the points cannot tell the parameters apart; ask for more points")
    return best


def _information_matrices(f: Array) -> Array:
    """Information matrices FᵀF for each parameter vector, shape (K, p, p)."""
    return np.asarray(f.transpose(0, 2, 1) @ f)
