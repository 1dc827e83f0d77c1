"""Errors of a model against simulations, and at points that it was not fitted to.

In cross-validation points of one gap and amplitude are held out together, wherever the finger is:
where a force hardly depends on its position they are copies, and no point is unseen whose copy was
fitted.
"""

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError
from squeezefilm.models.data import Factors
from squeezefilm.models.fitting import local_fit
from squeezefilm.models.force_model import ExpressionModel

Array = NDArray[np.float64]


def film_folds(factors: Factors, *, folds: int, seed: int) -> NDArray[np.int64]:
    """To which fold each point belongs, shape (n,): of as many as asked for, or as there are pairs
    of a gap and an amplitude if these are fewer; all points of a pair to one."""
    films = pd.DataFrame({"h0_m": factors.h0_m, "hv_m": factors.hv_m})
    film = films.groupby(["h0_m", "hv_m"], sort=False).ngroup().to_numpy()
    return np.random.default_rng(seed).permutation(np.arange(film.max() + 1) % folds)[film]


def left_out_predictions(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    *,
    theta: ArrayLike,
    folds: NDArray[np.int64],
) -> Array:
    """Each point's force by the model fitted to the other folds of films, in newtons, shape (n,).

    ``theta`` is where the fits start: that of all points; ``folds`` are those of ``film_folds``.
    NaN where the model, fitted to the others, is undefined, and everywhere where a fold leaves
    fewer points than parameters. Raises InputError where a fit is impossible.
    """
    force = np.asarray(force_n, dtype=float)
    predicted = np.full(len(force), np.nan)
    if len(force) - np.bincount(folds).max() < max(len(model.parameter_names), 1):
        return predicted
    for fold in np.unique(folds):
        out = folds == fold
        found = local_fit(model, factors.take(~out), force[~out], theta)
        predicted[out] = model.evaluate(found, factors.take(out))
    return predicted


def relative_errors(*, model_n: ArrayLike, simulation_n: ArrayLike) -> Array:
    """(model - simulation)/simulation for each point, shape (n,), from forces in newtons.

    Raises InputError for forces that are not finite, for none, or for a
    simulated force of zero.
    """
    model, simulation = (np.atleast_1d(np.asarray(f, dtype=float)) for f in (model_n, simulation_n))
    if len(model) == 0:
        raise InputError("validation: no points; give at least one")
    for name, force in (("model_n", model), ("simulation_n", simulation)):
        if not np.all(np.isfinite(force)):
            raise InputError(f"{name}: a force is not a finite number; all must be")
    if np.any(simulation == 0):
        raise InputError("simulation_n: a force is zero; its relative error is undefined")
    return np.asarray((model - simulation) / simulation)


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
