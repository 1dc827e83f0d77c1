"""What a fit's file tells of a fit, so that the model can be used from the file alone."""

from typing import Any

import numpy as np

from squeezefilm.models.cross_validation import film_folds, left_out_predictions
from squeezefilm.models.fitting.fit import Fit
from squeezefilm.models.force_model import POLAR, POSITION, ExpressionModel, Factors
from squeezefilm.models.prediction_interval import error_scale
from squeezefilm.models.validation import error_sizes

FOLDS, FOLD_SEED = 5, 1
"""Of the cross-validation that tells a fit's error at points it was not fitted to."""


def describe(
    model: ExpressionModel,
    factors: Factors,
    force_n: np.ndarray,
    fit: Fit,
    *,
    profile_uncertainty: float,
) -> dict[str, Any]:
    """Formula, units, ranges and errors of a fit.

    profile_uncertainty: share of a force that the scan of a measured profile leaves open.
    """
    # A model that knows no position was fitted at some all the same.
    position = () if set(model.factor_names) & set(POSITION) else POLAR[:1]
    left_out = _left_out(model, factors, force_n, fit)
    fitted_n = model.evaluate(fit.theta, factors)
    residual_n = np.full(len(force_n), np.nan) if left_out is None else left_out - force_n
    return {
        "about": model.about,
        "expression": model.expression,
        "parameters": list(model.parameter_names),
        "parameter_units": list(model.parameter_units),
        "force_unit": "N",
        "ranges": {
            name: [float(np.min(values)), float(np.max(values))]
            for name in (*model.factor_names, *position, *model.column_names)
            for values in [factors.column(name)]
        },
        "residual": error_sizes(model_n=fitted_n, simulation_n=force_n),
        "cross_validation": None
        if left_out is None
        else {
            "folds": len(_points_by_fold(factors)),
            **error_sizes(model_n=left_out, simulation_n=force_n),
        },
        "error_scale": list(error_scale(residual_n, force_n)),
        "profile_uncertainty": profile_uncertainty,
    }


def _left_out(
    model: ExpressionModel, factors: Factors, force_n: np.ndarray, fit: Fit
) -> np.ndarray | None:
    """Forces at points left out of the fit; none where they are too few to leave any out."""
    if len(force_n) - _points_by_fold(factors).max() < max(len(model.parameter_names), 1):
        return None
    predicted = left_out_predictions(
        model, factors, force_n, theta=fit.theta, folds=FOLDS, seed=FOLD_SEED
    )
    return predicted if np.all(np.isfinite(predicted)) else None


def _points_by_fold(factors: Factors) -> np.ndarray:
    return np.bincount(film_folds(factors, folds=FOLDS, seed=FOLD_SEED))
