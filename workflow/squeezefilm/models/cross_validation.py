"""How well a model predicts points that it was not fitted to, from the points there are.

Points of one gap and amplitude are left out together, wherever the finger is: where a force hardly
depends on its position they are copies, and no point is unseen whose copy was fitted.
"""

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


def film_folds(factors: Factors, *, folds: int, seed: int) -> NDArray[np.int64]:
    """To which fold each point belongs, shape (n,): of as many as asked for, or as there are pairs
    of a gap and an amplitude if these are fewer; all points of a pair to one."""
    pairs = np.column_stack([factors.h0_m, factors.hv_m])
    _, first, pair = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    in_order = np.argsort(np.argsort(first))[pair.ravel()]
    if len(first) == 1:
        return in_order
    numbers = fold_numbers(points=len(first), folds=min(folds, len(first)), seed=seed)
    return numbers[in_order]


def left_out_predictions(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    *,
    theta: ArrayLike,
    folds: int,
    seed: int,
) -> Array:
    """Each point's force by the model fitted to the other folds of films, in newtons, shape (n,).

    ``theta`` is where the fits start: that of all points. NaN where the model, fitted to the
    others, is undefined.
    Raises InputError where a fold leaves fewer points than parameters, or a fit is impossible.
    """
    force = np.asarray(force_n, dtype=float)
    numbers = film_folds(factors, folds=folds, seed=seed)
    predicted = np.empty(len(force))
    for fold in np.unique(numbers):
        out = numbers == fold
        if np.sum(~out) < len(model.parameter_names):
            raise InputError(
                f"folds: {np.sum(~out)} points are left for the {len(model.parameter_names)} "
                f"parameters of the {model.name} model"
            )
        found = local_fit(model, factors.take(~out), force[~out], theta)
        predicted[out] = model.evaluate(found, factors.take(out))
    return predicted
