"""Least squares near a known solution."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

from squeezefilm.io.errors import InputError
from squeezefilm.models.force_model import ExpressionModel, Factors

Array = NDArray[np.float64]


def local_fit(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    start: ArrayLike,
    *,
    fixed: int | None = None,
) -> Array:
    """Parameters of the least sum of squares next to a start, shape (p,).

    A parameter may be held fixed, by its place. force_n has shape (n,). Where the model is linear
    the start does not matter. Steps to where the model is undefined are taken back.
    Raises InputError where the model is undefined at the start, or has no derivative on the way.
    """
    force = np.asarray(force_n, dtype=float)
    theta = np.array(start, dtype=float)
    free = np.array([index for index in range(len(theta)) if index != fixed], dtype=int)

    def whole(part: Array) -> Array:
        full = theta.copy()
        full[free] = part
        return full

    def residuals(part: Array) -> Array:
        return model.evaluate(whole(part), factors) - force

    def slopes(part: Array) -> Array:
        return model.gradient(whole(part), factors)[:, free]

    undefined = np.flatnonzero(np.isnan(residuals(theta[free])))
    if len(undefined):
        raise InputError(
            f"fit: the {model.name} model is undefined "
            f"{model.described(theta, factors, undefined[0])}"
        )
    if len(free) == 0:
        return theta
    if model.is_linear:  # exact in one step, whatever the parameters' sizes
        rows = slopes(theta[free])
        size = np.linalg.norm(rows, axis=0)
        size = np.where(size > 0, size, 1.0)
        change = np.linalg.lstsq(rows / size, -residuals(theta[free]), rcond=None)[0] / size
        return whole(theta[free] + change)
    with np.errstate(all="ignore"):  # steps may lead far away, and are taken back
        found = least_squares(
            residuals, theta[free], jac=slopes, x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15
        )
    return whole(found.x)


def sum_of_squares(
    model: ExpressionModel, factors: Factors, force_n: ArrayLike, theta: ArrayLike
) -> float:
    """Sum of squared residuals in N^2; infinite where the model is undefined at a point."""
    misses = model.evaluate(theta, factors) - np.asarray(force_n, dtype=float)
    total = float(np.sum(misses**2))
    return total if np.isfinite(total) else np.inf
