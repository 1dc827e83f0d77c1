"""How well a model predicts points that it was not fitted to, from the points there are."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.io.errors import InputError
from squeezefilm.models.fitting.local_fit import local_fit
from squeezefilm.models.force_model import ExpressionModel, Factors

Array = NDArray[np.float64]


def fold_numbers(*, points: int, folds: int, seed: int) -> NDArray[np.int64]:
    """To which of the folds each point belongs, shape (points,); sizes differ by at most one.

    Raises InputError for fewer than two folds, or more than points.
    """
    if not 2 <= folds <= points:
        raise InputError(f"folds: {folds} for {points} points; give 2 … {points}")
    numbers = np.arange(points) % folds
    return np.random.default_rng(seed).permutation(numbers)


def left_out_predictions(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    *,
    theta: ArrayLike,
    folds: int,
    seed: int,
) -> Array:
    """Each point's force by the model fitted to the other folds, in newtons, shape (n,).

    ``theta`` is where the fits start: that of all points. NaN where the model, fitted to the
    others, is undefined.
    Raises InputError where a fold leaves fewer points than parameters, or a fit is impossible.
    """
    force = np.asarray(force_n, dtype=float)
    numbers = fold_numbers(points=len(force), folds=folds, seed=seed)
    predicted = np.empty(len(force))
    for fold in range(folds):
        out = numbers == fold
        if np.sum(~out) < len(model.parameter_names):
            raise InputError(
                f"folds: {np.sum(~out)} points are left for the {len(model.parameter_names)} "
                f"parameters of the {model.name} model"
            )
        found = local_fit(model, factors.take(~out), force[~out], theta)
        predicted[out] = model.evaluate(found, factors.take(out))
    return predicted
