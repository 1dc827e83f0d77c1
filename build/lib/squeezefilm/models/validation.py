"""How far a fitted model is from simulated forces, point by point and as a whole."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.io.errors import InputError

Array = NDArray[np.float64]


def relative_errors(*, model_n: ArrayLike, simulation_n: ArrayLike) -> Array:
    """(model - simulation)/simulation for each point, shape (n,), from forces in newtons.

    Raises InputError for forces that are not finite, of different lengths or none, or for a
    simulated force of zero.
    """
    model, simulation = _checked(model_n, simulation_n)
    if np.any(simulation == 0):
        raise InputError("simulation_n: a force is zero; its relative error is undefined")
    return (model - simulation) / simulation


def summarise(*, model_n: ArrayLike, simulation_n: ArrayLike, band: float) -> dict[str, Any]:
    """Errors of modelled against simulated forces, both in newtons, shape (n,), ready for JSON.

    sum_of_squares is in N^2; global_error is |model - simulation|/|simulation|, norms over all
    points; share_within_band is the share of points with a relative error of at most `band` in
    magnitude; worst_index is the point of the largest relative error, worst_relative_error it.
    Raises InputError as relative_errors does.
    """
    model, simulation = _checked(model_n, simulation_n)
    relative = relative_errors(model_n=model, simulation_n=simulation)
    squares = float(np.sum((model - simulation) ** 2))
    worst = int(np.argmax(np.abs(relative)))
    return {
        "points": len(relative),
        "sum_of_squares": squares,
        "global_error": float(np.sqrt(squares) / np.linalg.norm(simulation)),
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
    model, simulation = _checked(model_n, simulation_n)
    relative = relative_errors(model_n=model, simulation_n=simulation)
    error = model - simulation
    return {
        "global_error": float(np.linalg.norm(error) / np.linalg.norm(simulation)),
        "root_mean_square_n": float(np.sqrt(np.mean(error**2))),
        "largest_n": float(np.max(np.abs(error))),
        "largest_relative": float(np.max(np.abs(relative))),
    }


def _checked(model_n: ArrayLike, simulation_n: ArrayLike) -> tuple[Array, Array]:
    model = np.atleast_1d(np.asarray(model_n, dtype=float))
    simulation = np.atleast_1d(np.asarray(simulation_n, dtype=float))
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
    return model, simulation
