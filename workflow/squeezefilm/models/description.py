"""What a fit's file tells of a fit, so that the model can be used from the file alone."""

from typing import Any

import numpy as np

from squeezefilm.models.cross_validation import film_folds, left_out_predictions
from squeezefilm.models.fitting.fit import Fit
from squeezefilm.models.force_model import POLAR, POSITION, ExpressionModel, Factors
from squeezefilm.models.trust import Trust, Unseen
from squeezefilm.models.validation import error_sizes

FOLDS, FOLD_SEED = 5, 1
"""Of the cross-validation that tells a fit's error at points it was not fitted to."""


def describe(
    model: ExpressionModel,
    factors: Factors,
    force_n: np.ndarray,
    fit: Fit,
    *,
    force_error_n: np.ndarray,
    scan_error: float,
    control: Unseen | None = None,
) -> dict[str, Any]:
    """Formula, units, ranges and errors of a fit, and the evidence by which it is trusted.

    scan_error: share of a force that the scan of a measured profile leaves open.
    control: simulations that were not fitted, to judge the fit by, besides points left out.
    """
    # A model that knows no position was fitted at some all the same.
    position = () if set(model.factor_names) & set(POSITION) else POLAR[:1]
    left_out = _left_out(model, factors, force_n, fit)
    fitted_n = model.evaluate(fit.theta, factors)
    unseen = None
    if left_out is not None:
        # A point left out may lie nearer to the others' fit than it does to the fit of all.
        off = np.abs(fitted_n - force_n) > np.abs(left_out - force_n)
        model_n = np.where(off, fitted_n, left_out)
        unseen = Unseen.of(factors, model_n=model_n, force_n=force_n, force_error_n=force_error_n)
    trust = Trust.of(factors, unseen, scan_error=scan_error)
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
        "trust": (trust if control is None else trust.with_control(control)).to_dict(),
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
