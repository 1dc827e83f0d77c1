"""Errors of a model against simulations, and at points that it was not fitted to.

In cross-validation points of one gap and amplitude are held out together, wherever the finger is:
where a force hardly depends on its position they are copies, and no point is unseen whose copy was
fitted.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError
from squeezefilm.models.data import Factors
from squeezefilm.models.fitting import local_fit
from squeezefilm.models.force_model import ExpressionModel

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


def relative_errors(*, model_n: ArrayLike, simulation_n: ArrayLike) -> Array:
    """(model - simulation)/simulation for each point, shape (n,), from forces in newtons.

    Raises InputError for forces that are not finite, of different lengths or none, or for a
    simulated force of zero.
    """
    model, simulation = (np.atleast_1d(np.asarray(f, dtype=float)) for f in (model_n, simulation_n))
    if model.shape != simulation.shape or model.ndim != 1:
        raise InputError(
            f"validation: {model.size} modelled and {simulation.size} simulated forces; "
            "give one of each for every point"
        )
    if len(model) == 0:
        raise InputError("validation: no points; give at least one")
    for name, force in (("model_n", model), ("simulation_n", simulation)):
        if not np.all(np.isfinite(force)):
            raise InputError(f"{name}: a force is not a finite number; all must be")
    if np.any(simulation == 0):
        raise InputError("simulation_n: a force is zero; its relative error is undefined")
    return np.asarray((model - simulation) / simulation)


def summarise(*, model_n: ArrayLike, simulation_n: ArrayLike, band: float) -> dict[str, Any]:
    """Errors of modelled against simulated forces, both in newtons, shape (n,), ready for JSON.

    sum_of_squares is in N^2; global_error is |model - simulation|/|simulation|, norms over all
    points; share_within_band is the share of points with a relative error of at most `band` in
    magnitude; worst_index is the point of the largest relative error, worst_relative_error it.
    Raises InputError as relative_errors does.
    """
    relative = relative_errors(model_n=model_n, simulation_n=simulation_n)
    sizes = error_sizes(model_n=model_n, simulation_n=simulation_n)
    worst = int(np.argmax(np.abs(relative)))
    return {
        "points": len(relative),
        "sum_of_squares": len(relative) * sizes["root_mean_square_n"] ** 2,
        "global_error": sizes["global_error"],
        "band": band,
        "share_within_band": float(np.mean(np.abs(relative) <= band)),
        "worst_index": worst,
        "worst_relative_error": float(relative[worst]),
    }


def error_sizes(*, model_n: ArrayLike, simulation_n: ArrayLike) -> dict[str, float]:
    """Errors of modelled against simulated forces, both in newtons, shape (n,), in four numbers.

    ``global_error`` is |model - simulation|/|simulation|, ``root_mean_square_n`` and ``largest_n``
    are in newtons, ``largest_relative`` is the largest relative error in magnitude. Raises
    InputError as relative_errors does.
    """
    relative = relative_errors(model_n=model_n, simulation_n=simulation_n)
    error = np.asarray(model_n) - np.asarray(simulation_n)
    return {
        "global_error": float(np.linalg.norm(error) / np.linalg.norm(simulation_n)),
        "root_mean_square_n": float(np.sqrt(np.mean(error**2))),
        "largest_n": float(np.max(np.abs(error))),
        "largest_relative": float(np.max(np.abs(relative))),
    }
