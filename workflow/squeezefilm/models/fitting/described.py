"""A model fitted and described: what its file holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from squeezefilm.models.description import describe
from squeezefilm.models.experiments import check_columns
from squeezefilm.models.fitting.fit import Fit, fits_from_seeds
from squeezefilm.models.fitting.identifiability import check_identifiable
from squeezefilm.models.force_model import ExpressionModel, Factors


def described_fit(
    model: ExpressionModel,
    factors: Factors,
    force_n: np.ndarray,
    *,
    settings: Mapping[str, Any],
    profile_uncertainty: float,
    processes: int = 1,
) -> tuple[dict[str, Any], list[Fit]]:
    """The best of all runs with all that is known of it, and every run.

    Args:
        force_n: simulated forces in newtons, shape (n,).
        settings: the section ``fit`` of a study.
        profile_uncertainty: share of a force that the scan of a measured profile leaves open.

    Raises InputError where the model cannot be fitted to these points.
    """
    check_columns(model, factors)
    if len(factors) >= len(model.parameter_names):
        check_identifiable(model, factors)
    runs = fits_from_seeds(model, factors, force_n, settings, processes=processes)
    best = min(runs, key=lambda run: run.sum_of_squares)
    about = describe(model, factors, force_n, best, profile_uncertainty=profile_uncertainty)
    return {**best.to_dict(), **about}, runs
