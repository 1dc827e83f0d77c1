"""Whether a model's parameters can be told apart at all, by experiments at given points."""

import numpy as np
from numpy.typing import NDArray

from squeezefilm.io.errors import InputError
from squeezefilm.models.force_model import ExpressionModel, Factors

Array = NDArray[np.float64]

DRAWS, SEED = 400, 1
SPREADS = (2.0, 16.0)
"""Parameters are drawn as sinh of a uniform number within these: up to 4 and up to 4 million."""
LEAST_SINGULAR_VALUE = 1e-9
SHARE_OF_DIRECTION = 0.1


def best_told_apart(model: ExpressionModel, factors: Factors) -> tuple[float, Array, Array]:
    """Where experiments tell a model's parameters apart best, of random theta.

    The least singular value of the gradient with columns scaled to one, its direction, shape (p,),
    and theta, shape (p,). The least value is -1 where the model is undefined at every theta tried,
    and at most LEAST_SINGULAR_VALUE where no theta was found that the experiments tell apart.
    """
    count = len(model.parameter_names)
    random = np.random.default_rng(SEED)
    best, direction, where = -1.0, np.zeros(count), np.zeros(count)
    for draw in range(DRAWS):
        spread = SPREADS[draw % len(SPREADS)]
        theta = np.sinh(random.uniform(-spread, spread, count))
        try:
            gradient = model.gradient(theta, factors)
        except InputError:  # a number within the formula that exceeds the largest there is
            continue
        gradient = gradient[np.isfinite(gradient).all(axis=1)]
        if len(gradient) < count:
            continue
        least, along = _weakest(gradient)
        if least > best:
            best, direction, where = least, along, theta
        if best > 1e3 * LEAST_SINGULAR_VALUE:
            break
    return best, direction, where


def check_identifiable(model: ExpressionModel, factors: Factors) -> None:
    """See that the gradient has full rank at some theta, so that a fit can have one answer.

    The rank is taken numerically, with columns scaled to one, at many random theta at which the
    model is defined: what fails at all of them is a property of the model and the points.
    Raises InputError naming the parameters that the points cannot tell apart, or a model that is
    undefined wherever it was tried.
    """
    if not model.parameter_names:
        return
    best, direction, _ = best_told_apart(model, factors)
    if best < 0:
        raise InputError(
            f"{model.place}: the formula is undefined at {DRAWS} random parameter sets; no fit can "
            "start from there"
        )
    if best <= LEAST_SINGULAR_VALUE:
        share = np.abs(direction) / np.abs(direction).max()
        names = [
            name
            for name, each in zip(model.parameter_names, share, strict=True)
            if each > SHARE_OF_DIRECTION
        ]
        what = (
            f"{names[0]} has no effect on the force"
            if len(names) == 1
            else f"{', '.join(names)} cannot be told apart"
        )
        raise InputError(
            f"{model.place}: {what} at these points; leave a parameter out, or vary the factors "
            "that it belongs to"
        )


def _weakest(gradient: Array) -> tuple[float, Array]:
    """The least singular value of a gradient with columns of length one, and its direction."""
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.linalg.norm(gradient, axis=0)
    if np.any(length == 0):
        return 0.0, (length == 0).astype(float)
    if not np.all(np.isfinite(length)):
        return -1.0, length
    _, values, directions = np.linalg.svd(gradient / length, full_matrices=False)
    return float(values[-1]), directions[-1]
