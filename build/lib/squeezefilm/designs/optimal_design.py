"""Approximate D-optimal designs, with a certificate: how far any design can be from the best.

An approximate design gives each candidate point x_i a weight w_i >= 0, summing to one; its
information matrix is M = sum w_i f_i f_i', with f_i the derivatives of the response at x_i. Since
log det M is concave in the weights, the best design is known when it is found (Kiefer and
Wolfowitz 1960): a design is D-optimal if and only if its sensitivity d(x) = f(x)' M^-1 f(x) is
nowhere above the number of parameters p. For any other design it says how far off it is: with
M* the best matrix, tr(M^-1 M*) <= max d, and by the inequality of arithmetic and geometric means
(det M / det M*)^(1/p) >= p / max d.

Uncertain parameters. Derivatives may come as a stack, one layer for each of K parameter vectors:
the criterion is then the mean of log det M_k (Bayesian D), and everything above holds for the
mean of d_k. `maximin_design` makes the least of the K efficiencies large.

Derivatives have shape (n, p) or (K, n, p); rows that are undefined (NaN) carry no information.
Nothing here knows a model, a factor or a unit, and D-optimality does not depend on the parameters'.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import qr
from scipy.optimize import minimize, nnls

from squeezefilm.io.errors import InputError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

DROPPED = 1e-9
"""Weight below which a point is left out of a support."""
ROUNDS = 500
MAXIMIN_GAP, MAXIMIN_ROUNDS = 1e-5, 30


@dataclass(frozen=True, eq=False)
class ApproximateDesign:
    """Weights over n candidates and what is known of their quality.

    weights, shape (n,), sum to one. sensitivity, shape (n,), is d(x)/p: nowhere above one for the
    best design, and one at its points. log_det, shape (K,), is log det M for each parameter
    vector, in the units of the derivatives. efficiency_bound is a lower bound of the D-efficiency
    against all designs on these candidates; for a maximin design, of its least efficiency over the
    best possible one.
    """

    weights: Array
    sensitivity: Array
    log_det: Array
    efficiency_bound: float

    @property
    def support(self) -> Indices:
        """Indices of the candidates that have a weight."""
        return np.flatnonzero(self.weights > DROPPED)


def optimal_weights(derivatives: ArrayLike, *, gap: float = 1e-6) -> ApproximateDesign:
    """The D-optimal weights of n candidates, to an efficiency of 1 - gap.

    On a small active set weight is moved between pairs of points, each time by the exact best step
    (vertex exchange, Boehning 1986), with Newton steps between; the candidates of largest
    sensitivity join the set until the equivalence theorem holds for all.

    derivatives are those of the candidates, shape (n, p) or (K, n, p).
    Raises InputError where the candidates cannot tell the parameters apart.
    """
    problem = _problem(derivatives)
    active = _first_points(problem)
    weights = np.zeros(problem.points)
    weights[active] = 1 / len(active)
    for _ in range(ROUNDS):
        sensitivity = problem.sensitivity(weights)
        if sensitivity.max() <= 1 + gap:
            break
        most = np.argpartition(sensitivity, -problem.parameters)[-problem.parameters :]
        active = np.union1d(np.flatnonzero(weights > 0), most)
        weights[active] = _best_weights(problem.only(active), weights[active], gap=gap / 4)
        weights[weights < DROPPED / 10] = 0
        weights /= weights.sum()
    return problem.design(weights)


def maximin_design(derivatives: ArrayLike) -> tuple[ApproximateDesign, Array]:
    """Weights with the largest least D-efficiency over K parameter vectors, and the efficiencies.

    derivatives has shape (K, n, p). Efficiency k is (det M_k / det M_k*)^(1/p) against the best
    design for vector k alone. Sequential quadratic programming on a small active set; the
    multipliers of the least favourable vectors make the sensitivity of the equivalence theorem.
    """
    stack = stacked_derivatives(derivatives)
    best = [optimal_weights(layer, gap=MAXIMIN_GAP / 10) for layer in stack]
    goal = np.array([float(design.log_det[0]) for design in best])
    problem = _problem(stack)
    goal = goal + problem.scale_log_det
    start = optimal_weights(stack, gap=1e-3)
    weights = start.weights + sum(design.weights for design in best) / len(best)
    weights /= weights.sum()
    found = start
    efficiencies = np.zeros(len(stack))
    for _ in range(MAXIMIN_ROUNDS):
        active = np.flatnonzero(weights > DROPPED)
        weights[active] = _maximin_weights(problem.only(active), weights[active], goal)
        weights[weights <= DROPPED] = 0
        weights /= weights.sum()
        log_efficiency = (problem.log_dets(weights) - goal) / problem.parameters
        efficiencies = np.exp(log_efficiency)
        prior = _least_favourable(problem, weights, log_efficiency)
        sensitivity = replace(problem, prior=prior).sensitivity(weights)
        ceiling = float(prior @ log_efficiency) + np.log(sensitivity.max())
        found = ApproximateDesign(
            weights=weights.copy(),
            sensitivity=sensitivity,
            log_det=problem.log_dets(weights) - problem.scale_log_det,
            efficiency_bound=float(min(1.0, np.exp(log_efficiency.min() - ceiling))),
        )
        if found.efficiency_bound >= 1 - MAXIMIN_GAP:
            break
        most = np.argsort(sensitivity)[-problem.parameters :]
        weights[most] += 1e-3
        weights /= weights.sum()
    return found, efficiencies


@dataclass(frozen=True, eq=False)
class _Problem:
    """Candidates' derivatives, shape (K, n, p), scaled so that their plain mean has M = I.

    prior, shape (K,), are the weights of the parameter vectors.
    """

    derivatives: Array
    prior: Array
    scale_log_det: Array

    @property
    def points(self) -> int:
        return int(self.derivatives.shape[1])

    @property
    def parameters(self) -> int:
        return int(self.derivatives.shape[2])

    def only(self, which: Indices) -> _Problem:
        return replace(self, derivatives=self.derivatives[:, which])

    def information(self, weights: Array) -> Array:
        """M of each parameter vector, shape (K, p, p)."""
        used = np.flatnonzero(weights)
        f = self.derivatives[:, used]
        return np.asarray(np.einsum("kni,n,knj->kij", f, weights[used], f))

    def log_dets(self, weights: Array) -> Array:
        sign, value = np.linalg.slogdet(self.information(weights))
        return np.asarray(np.where(sign > 0, value, -np.inf), dtype=float)

    def inverse(self, weights: Array) -> Array:
        try:
            return np.asarray(np.linalg.inv(self.information(weights)), dtype=float)
        except np.linalg.LinAlgError:
            raise InputError(
                "design: the points cannot tell the parameters apart; give more points, or a "
                "model with fewer parameters"
            ) from None

    def variances(self, weights: Array) -> Array:
        """d_k(x) of every candidate, shape (K, n)."""
        f = self.derivatives
        return np.asarray(np.einsum("kni,kij,knj->kn", f, self.inverse(weights), f))

    def sensitivity(self, weights: Array) -> Array:
        """Mean of d_k over p, written so that it is one for the mean over the design's points."""
        variance = self.prior @ self.variances(weights)
        own = float(weights @ variance)
        return np.asarray(1 + (variance - own) / self.parameters)

    def design(self, weights: Array) -> ApproximateDesign:
        log_det = self.log_dets(weights)
        if not np.all(np.isfinite(log_det)):
            return ApproximateDesign(
                weights, np.full(self.points, np.inf), log_det - self.scale_log_det, 0.0
            )
        sensitivity = self.sensitivity(weights)
        return ApproximateDesign(
            weights=weights,
            sensitivity=sensitivity,
            log_det=log_det - self.scale_log_det,
            efficiency_bound=float(min(1.0, 1 / sensitivity.max())),
        )


def stacked_derivatives(derivatives: ArrayLike) -> Array:
    """Derivatives of shape (n, p) or (K, n, p) as (K, n, p); undefined rows become zero."""
    f = np.asarray(derivatives, dtype=float)
    if f.ndim not in (2, 3):
        raise InputError(f"design: derivatives have shape (n, p) or (K, n, p), not {f.shape}")
    f = f if f.ndim == 3 else f[None]
    return np.where(np.isfinite(f).all(axis=-1, keepdims=True), f, 0.0)


def _problem(derivatives: ArrayLike) -> _Problem:
    f = stacked_derivatives(derivatives)
    layers, _, parameters = f.shape
    scale = np.empty((layers, parameters, parameters))
    for layer, each in zip(scale, f, strict=True):
        columns = np.linalg.norm(each, axis=0)
        if len(each) < parameters or not np.all(columns > 0):
            raise InputError("design: a parameter has no influence on any candidate")
        triangle = np.linalg.qr(each / columns, mode="r")
        if np.abs(np.diagonal(triangle)).min() < 1e-13:
            raise InputError("design: the candidates cannot tell the parameters apart")
        layer[:] = np.linalg.inv(triangle) / columns[:, None] * np.sqrt(len(each))
    return _Problem(
        derivatives=f @ scale,
        prior=np.full(layers, 1 / layers),
        scale_log_det=np.asarray(2 * np.linalg.slogdet(scale)[1], dtype=float),
    )


def _first_points(problem: _Problem) -> Indices:
    """For each parameter vector p points of large determinant: pivots of a QR decomposition."""
    picks = [qr(layer.T, mode="r", pivoting=True)[1] for layer in problem.derivatives]
    return np.unique(np.concatenate([pick[: problem.parameters] for pick in picks]))


def _best_weights(problem: _Problem, weights: Array, *, gap: float) -> Array:
    """The best weights of a few points: exchanges between pairs, each followed by a Newton step.

    Exchanges bring points in and out, Newton's method makes the end quick.
    """
    for _ in range(20 * problem.points):
        f, inverse = problem.derivatives, problem.inverse(weights)
        turned = f @ inverse
        variance = np.einsum("kni,kni->kn", turned, f)
        mean = problem.prior @ variance
        used = np.flatnonzero(weights > 0)
        to, of = int(np.argmax(mean)), int(used[np.argmin(mean[used])])
        if mean[to] - mean[of] <= gap * problem.parameters:
            break
        mixed = np.einsum("ki,ki->k", turned[:, to], f[:, of])
        rise = variance[:, to] - variance[:, of]
        fall = variance[:, to] * variance[:, of] - mixed**2
        step = _best_step(problem.prior, rise, np.maximum(fall, 0), float(weights[of]))
        weights = weights.copy()
        weights[to] += step
        weights[of] = 0 if step >= weights[of] else weights[of] - step
        weights = _newton_step(problem, weights)
    return weights


def _newton_step(problem: _Problem, weights: Array) -> Array:
    """Newton's step for the weights that are not zero, as far as it helps and none is negative."""
    used = np.flatnonzero(weights > 0)
    if len(used) < 2:
        return weights
    f = problem.derivatives[:, used]
    cross = f @ problem.inverse(weights) @ f.transpose(0, 2, 1)
    slope = problem.prior @ np.diagonal(cross, axis1=1, axis2=2)
    one = np.ones((len(used), 1))
    bend = np.einsum("k,kij->ij", problem.prior, cross**2)
    matrix = np.block([[bend, one], [one.T, np.zeros((1, 1))]])
    change = np.linalg.lstsq(matrix, np.append(slope, 0.0), rcond=1e-12)[0][:-1]
    change -= change.mean()
    shrinking = change < 0
    limit = float(np.min(-weights[used][shrinking] / change[shrinking], initial=1.0))
    before = float(problem.prior @ problem.log_dets(weights))
    for step in limit * 0.5 ** np.arange(8):
        moved = weights.copy()
        moved[used] = np.maximum(weights[used] + step * change, 0)
        moved[used[moved[used] < DROPPED / 100]] = 0
        moved /= moved.sum()
        if float(problem.prior @ problem.log_dets(moved)) > before:
            return moved
    return weights


def _best_step(prior: Array, rise: Array, fall: Array, most: float) -> float:
    """The a in [0, most] with the largest mean of log(1 + a rise - a^2 fall), a concave function.

    That is the gain in log det M when the weight a moves from one point to another.
    """

    def slope(a: float) -> float:
        ratio = 1 + a * rise - a * a * fall
        return -np.inf if np.any(ratio <= 0) else float(prior @ ((rise - 2 * a * fall) / ratio))

    if len(prior) == 1:
        return most if fall[0] <= 0 else min(most, float(rise[0] / (2 * fall[0])))
    if slope(most) >= 0:
        return most
    low, high = 0.0, most
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if slope(middle) > 0 else (low, middle)
    return low


def _maximin_weights(problem: _Problem, weights: Array, goal: Array) -> Array:
    """Weights of a few points that maximise the least of log det M_k - goal_k."""
    count, parameters = problem.points, problem.parameters

    def margins(z: Array) -> Array:
        return (problem.log_dets(np.maximum(z[:-1], 0)) - goal) / parameters - z[-1]

    def slopes(z: Array) -> Array:
        variance = problem.variances(np.maximum(z[:-1], 0)) / parameters
        return np.column_stack([variance, -np.ones(len(goal))])

    least = float(np.min((problem.log_dets(weights) - goal) / parameters))
    one = np.append(np.ones(count), 0.0)
    step = minimize(
        lambda z: -z[-1],
        np.append(weights, least),
        jac=lambda z: np.append(np.zeros(count), -1.0),
        method="SLSQP",
        bounds=[(0.0, 1.0)] * count + [(None, 0.0)],
        constraints=[
            {"type": "ineq", "fun": margins, "jac": slopes},
            {"type": "eq", "fun": lambda z: one @ z - 1, "jac": lambda z: one},
        ],
        options={"ftol": 1e-12, "maxiter": 200},
    )
    found = np.clip(step.x[:-1], 0, 1)
    found /= found.sum()
    better = np.min(problem.log_dets(found) - goal) / parameters > least
    return found if better else weights


def _least_favourable(problem: _Problem, weights: Array, log_efficiency: Array) -> Array:
    """Weights of the parameter vectors under which the design is nearly D-optimal."""
    close = np.flatnonzero(log_efficiency <= log_efficiency.min() + 1e-4)
    support = np.flatnonzero(weights > DROPPED)
    levels = problem.variances(weights)[np.ix_(close, support)] / problem.parameters
    strong = 1e3  # the weights must sum to one
    rows = np.vstack([levels.T * np.sqrt(weights[support])[:, None], np.full(len(close), strong)])
    prior = np.zeros(len(log_efficiency))
    prior[close] = nnls(rows, np.append(np.sqrt(weights[support]), strong))[0]
    return prior / prior.sum()
