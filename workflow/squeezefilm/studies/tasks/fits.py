"""Models fitted to the simulations of a study, and the errors of a fit on simulated points."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm import __version__
from squeezefilm.config.study import Study
from squeezefilm.errors import InputError
from squeezefilm.files import read_json
from squeezefilm.film.positions import POLAR_COLUMNS, columns_in_table_form
from squeezefilm.models.data import POSITION_COLUMNS, Factors, factors_of_table
from squeezefilm.models.fit_file import FIT_FILE_FORMAT_VERSION, FittedModel, fit_from_values
from squeezefilm.models.fitting import (
    PARAMETER_RANGES_NOTE,
    Fit,
    ParameterRange,
    best_fit_of_bounds,
    check_identifiable,
    fits_of_searches,
    open_range_notes,
    parameter_ranges,
    run_differential_evolution,
    run_genetic_searches,
)
from squeezefilm.models.force_model import ExpressionModel, check_columns_known
from squeezefilm.models.prediction_interval import (
    conformal_interval,
    error_scale_of_residuals,
    error_statistics,
    fold_indices_of_points,
    held_out_predictions,
    relative_errors,
)
from squeezefilm.studies.space import space_of_study
from squeezefilm.studies.study import film_values, scenes_of_table
from squeezefilm.studies.tasks.physics_limits import (
    limit_table_of_study,
    with_asymptotic_forces,
    with_limit_forces,
)
from squeezefilm.studies.tasks.scan_errors import scan_errors_of_study
from squeezefilm.tables import ASYMPTOTIC_FORCE_COLUMNS, FACTOR_COLUMNS, SCENE_COLUMNS

CROSS_VALIDATION_FOLDS, CROSS_VALIDATION_SEED = 5, 1
"""Of the cross-validation that gives a fit's error at points it was not fitted to."""
MAX_LIMIT_TABLE_ERROR_FRACTION = 0.1
"""Largest error of a table of asymptotic forces over that of a model that uses it."""


def profile_uncertainty_fraction(config: Study, *, summary: Path | str | None = None) -> float:
    """Largest uncertainty of a force by the scan of a study's profile, a fraction; 0 without one.

    Args:
        summary: what is known of the scan, as its fit wrote it; simulated where it is not given.
    """
    if summary:
        return float(read_json(summary)["largest_force_error_fraction"])
    scan = config.smoothed_scan()
    if scan is None:
        return 0.0
    return float(scan_errors_of_study(config, scan)["scan_error_fraction"].max())


def asymptotic_forces_of_table(points: pd.DataFrame, config: Study) -> pd.DataFrame:
    """The asymptotic forces of the scenes of a table."""
    return with_asymptotic_forces(points, scenes_of_table(points, config))[
        columns_in_table_form(ASYMPTOTIC_FORCE_COLUMNS, points)
    ]


def limit_table_values(config: Study) -> dict[str, Any]:
    """A table of the asymptotic forces over the study's space for JSON, or why there is none."""
    try:
        return limit_table_of_study(config).model_dump(mode="json")
    except InputError as error:
        return {"not_supported": str(error)}


def fit_to_forces(
    model: ExpressionModel,
    config: Study,
    *,
    forces: pd.DataFrame,
    limit_table: dict[str, Any] | None = None,
    sample: pd.DataFrame | None = None,
    uncertainty: float | None = None,
    seeds: int | None = None,
    processes: int = 1,
    source: Mapping[str, str],
) -> tuple[FittedModel, pd.DataFrame]:
    """Fit a model to forces, every one of which is known.

    By every seed with every bound, and a differential evolution with every bound as a check.

    Args:
        limit_table: a table of the asymptotic forces over the space, with which the fit's file
            can be used alone: computed by default for a model that uses them.
        sample: forces of a validation sample, NaN where there is none.
        uncertainty: fraction of a force, by the scan of a measured profile; the study's by default.
        seeds: of the search, instead of the study's.
        source: where the forces come from, for the fit's file.

    Returns: the best run with all that is known of it, and a table of every run.

    Raises InputError where the model cannot be fitted to these points.
    """
    settings = config.fit
    if model.column_names and limit_table is None:
        limit_table = limit_table_values(config)
    if uncertainty is None:
        uncertainty = profile_uncertainty_fraction(config)
    factors = factors_of_table(with_limit_forces(model, forces, config))
    force_n = forces["force_n"].to_numpy()
    check_columns_known(model, factors)
    if len(factors) >= len(model.parameter_names):
        check_identifiable(model, factors)
    if seeds is None:
        seeds = (
            settings.seeds.two_factor if model.is_for_centred_pad else settings.seeds.four_factor
        )
    first = settings.first_seed
    searches = [
        *((run_genetic_searches, first + number) for number in range(seeds)),
        (run_differential_evolution, first),
    ]
    ways = [(bound, *search) for bound, search in product(settings.bounds, searches)]
    runs = fits_of_searches(ways, model, factors, force_n, processes=processes)
    best, bound_notes = best_fit_of_bounds(runs, model, factors, force_n)
    absent_terms = forces["absent_terms"]
    about = fit_values(model, config, factors, force_n, best, absent_terms, uncertainty=uncertainty)
    about["source"] = {"squeezefilm": __version__, **source}
    about["parameter_notes"] += bound_notes
    if model.column_names and limit_table and "not_supported" not in limit_table:
        about["limit_table"] = limit_table
    fit = fit_from_values(about, source=f"{config.study}: {model.name}")
    if sample is not None:
        fit = with_prediction_interval(fit, config, sample=sample)
    return fit, pd.DataFrame([_fit_run_row(run, model) for run in runs])


def fit_values(
    model: ExpressionModel,
    config: Study,
    factors: Factors,
    force_n: np.ndarray,
    fit: Fit,
    absent_terms: Iterable[str],
    *,
    uncertainty: float,
) -> dict[str, Any]:
    """A fit as its file holds it: formula, units, ranges, errors, and the study's film."""
    # A model that knows no position was fitted at some all the same.
    position = () if set(model.factor_names) & set(POSITION_COLUMNS) else POLAR_COLUMNS[:1]
    folds = fold_indices_of_points(
        factors, folds=CROSS_VALIDATION_FOLDS, seed=CROSS_VALIDATION_SEED
    )
    held_out = held_out_predictions(model, factors, force_n, theta=fit.theta, folds=folds)
    known = bool(np.isfinite(held_out).all())
    sizes = error_statistics(model_n=held_out, simulation_n=force_n) if known else {}
    ranges, notes = _parameter_ranges_and_notes(model, factors, force_n, fit.theta)
    missed_n = held_out - force_n if known else np.full(len(force_n), np.nan)
    return {
        "format": FIT_FILE_FORMAT_VERSION,
        **asdict(fit),
        "about": model.about,
        "expression": model.expression,
        "constants": dict(model.constants),
        "parameters": list(model.parameter_names),
        "parameter_units": list(model.parameter_units),
        "parameter_ranges": [parameter.to_dict() for parameter in ranges],
        "parameter_ranges_note": PARAMETER_RANGES_NOTE,
        "parameter_notes": notes,
        "ranges": {
            name: [float(np.min(values)), float(np.max(values))]
            for name in (*model.factor_names, *position, *model.column_names)
            for values in [factors.column(name)]
        },
        "cross_validation": {"folds": int(folds.max()) + 1, **sizes} if known else None,
        "error_scale": list(error_scale_of_residuals(missed_n, force_n)),
        "profile_uncertainty": uncertainty,
        "directions": config.symmetry().to_dict(),
        "film": film_values(config, absent_terms=absent_terms),
    }


def _parameter_ranges_and_notes(
    model: ExpressionModel, factors: Factors, force_n: np.ndarray, theta: tuple[float, ...]
) -> tuple[list[ParameterRange], list[str]]:
    """The range of each parameter and what to note of them, or why there are none."""
    if not theta:
        return [], []
    try:
        ranges = parameter_ranges(model, factors, force_n, theta)
    except InputError as error:
        return [], [str(error)]
    return ranges, open_range_notes(ranges)


def with_prediction_interval(
    fit: FittedModel, config: Study, *, sample: pd.DataFrame
) -> FittedModel:
    """The same fit with the prediction interval that a validation sample gives.

    Raises InputError where the fit's table of asymptotic forces errs by more than a tenth of the
    model, against the limits at the sample's points.
    """
    model = fit.force_model
    factors = factors_of_table(with_limit_forces(model, sample, config))
    force = sample["force_n"].where(sample["status"] == "ok").to_numpy()
    exact_n = model_n = model.evaluate(fit.theta, factors)
    if model.column_names and fit.limit_table is not None:
        model_n = model.evaluate(fit.theta, fit.limit_table.with_asymptotic_forces(factors))
        errors = exact_n - np.stack([force, model_n])
        errors = errors[:, np.isfinite(errors).all(axis=0)]
        own, table = np.sqrt(np.sum(errors**2, axis=1) / max(errors.shape[1], 1))
        if table > MAX_LIMIT_TABLE_ERROR_FRACTION * own:
            raise InputError(
                f"the table of asymptotic forces is too coarse for the study's space: it errs "
                f"by {table:.2g} N (root mean square over the validation sample) and the model "
                f"{fit.model} by {own:.2g} N; a tenth of that is allowed"
            )
    interval = conformal_interval(
        factors,
        model_n=model_n,
        force_n=force,
        force_error_n=sample["force_error_n"],
        scale=fit.error_scale,
        ranges=space_of_study(config, centred=not factors.phi_r_m.any()).limits_of_all_factors,
        profile_uncertainty=fit.profile_uncertainty,
    )
    return fit.model_copy(update={"prediction_interval": interval})


def _fit_run_row(fit: Fit, model: ExpressionModel) -> dict[str, object]:
    """A run as a table's row, a column for each parameter."""
    row = asdict(fit)
    theta = zip(model.parameter_names, row.pop("theta"), strict=True)
    return row | {f"parameter_{name}": value for name, value in theta}


def errors_of_fit(
    fit: FittedModel, forces: pd.DataFrame, config: Study
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """The errors of a fit on simulated forces: a table of its points, and their summary.

    The summary's sum of squares is in N², its global error |model - simulation|/|simulation|, norms
    over all points; it has the share of points within the study's band of relative errors.
    """
    band = config.validation.relative_error_band
    factors = factors_of_table(with_limit_forces(fit.force_model, forces, config))
    check_columns_known(fit.force_model, factors)
    predicted = fit.force_model.evaluate(fit.theta, factors)
    simulated = forces["force_n"].to_numpy()
    errors = relative_errors(model_n=predicted, simulation_n=simulated)
    sizes = error_statistics(model_n=predicted, simulation_n=simulated)
    worst = int(np.argmax(np.abs(errors)))
    table = forces[columns_in_table_form(SCENE_COLUMNS, forces)].assign(
        force_n=simulated, model_n=predicted, relative_error=errors
    )
    point = table.iloc[worst]
    return table, {
        "points": len(errors),
        "sum_of_squares": len(errors) * sizes["root_mean_square_n"] ** 2,
        "global_error": sizes["global_error"],
        "band": band,
        "fraction_within_band": float(np.mean(np.abs(errors) <= band)),
        "worst_relative_error": float(errors[worst]),
        "worst_point_id": point["point_id"],
        **{
            f"worst_{name}": float(point[name])
            for name in columns_in_table_form(FACTOR_COLUMNS, forces)
        },
    }
