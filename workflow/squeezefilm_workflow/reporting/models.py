"""The candidates for the force model side by side, the one that is recommended, those refined.

One half of a space's validation sample ranks the models, the other calibrated their prediction
intervals (``squeezefilm fit``). Points that have no force are excluded from the errors and counted.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import scipy

from squeezefilm.columns import COLUMNS
from squeezefilm.designs.optimal import sensitivity
from squeezefilm.errors import InputError
from squeezefilm.files import read_json
from squeezefilm.film.positions import columns_in_table_form, find_position_columns
from squeezefilm.models.data import Factors, factors_of_table
from squeezefilm.models.fit_file import FittedModel, amplitude_row, fit_from_values, read_fit
from squeezefilm.models.fitting import local_fit_theta, parameter_ranges
from squeezefilm.models.force_model import FACTOR_SPACE_NAMES, check_columns_known
from squeezefilm.models.prediction_interval import (
    error_statistics,
    ranking_points_mask,
    relative_errors,
)
from squeezefilm.tables import SCENE_COLUMNS, read_forces, read_ok_forces
from squeezefilm.units import error_text
from squeezefilm_workflow.reporting.notes import percent_text, with_minus_signs
from squeezefilm_workflow.reporting.pages import Page, readable_table
from squeezefilm_workflow.reporting.results import Results

MODEL_COLUMNS = (
    *("model", "parameters", "fit_points", "fit_error", "cv_error", "validation_points"),
    *("validation_failed", "validation_error", "validation_worst_relative", "validation_worst_n"),
    *("error_95_percent", "error_95_without_scan_percent", "coverage", "coverage_min"),
    *("coverage_min_region", "expression", "about", "note"),
)
SHOWN_COLUMN_TITLES = {
    "model": "model",
    "verdict": "verdict",
    "validation_error": "global error",
    "validation_worst_relative": "largest error of a validation point",
    "error_95_percent": "95 % error, median",
    "coverage": "coverage",
    "least_coverage": "least coverage",
    "parameters": "parameters",
    "fit_points": "fitted points",
    "fit_error": "global error of the fit",
    "cv_error": "of the cross-validation",
    "validation_points": "validation points",
    "validation_failed": "without a force",
    "validation_worst_n": "largest error (N)",
}
"""Columns of a comparison as its page has them, in words."""
MAX_EQUAL_ERROR_RATIO = 1.05
"""Of global errors: up to this times the least they are the same, for a sample has few points."""
TITLES_OF_COUNTS = ("fitted points", "validation points", "without a force")
"""Columns of a page that stand above its table where all models have the same number."""
COUNT_COLUMNS = ("parameters", "fit_points", "validation_points", "validation_failed")
RECOMMENDATION_PLANS = ("four_factor", *(f"validation_{space}" for space in FACTOR_SPACE_NAMES))
"""The plans that the recommended model is judged by; the first has the positions."""
RECOMMENDATION_COLUMNS = ("space", "model", "validation_error", "h0_m", "x_m", "y_m", "force_n")
"""Columns of a table with one empty row: no model can be judged."""


def models_page(results: Results, *, space: str) -> Page:
    """The page of a space's candidates (see ``compare_candidates``), the best on the sample
    first."""
    table, errors = compare_candidates(results, space)
    judged = ranked_models(table)
    fits = [read_fit(results.candidate_fit_file(space, model)) for model in judged["model"]]
    shown = shown_models_table(judged)
    same = [name for name in TITLES_OF_COUNTS if shown[name].nunique() == 1]
    values = {
        "space": space,
        "shown": shown.drop(columns=same),
        "counts": ", ".join(f"{name} {shown[name].iloc[0]}" for name in same),
        "statement": next((with_minus_signs(fit.statement) for fit in fits), ""),
        "profile_uncertainty": max((fit.profile_uncertainty for fit in fits), default=0.0),
        "formulas": judged[["model", "expression", "about"]].to_numpy().tolist(),
        "parameters": readable_table(_parameters_with_intervals(results, space, fits)),
        "results": results.folder,
        "not_validated": table[table["validation_error"].isna()].set_index("model")["note"],
    }
    return Page(values, {"table": table, "errors": errors})


def ranked_models(table: pd.DataFrame) -> pd.DataFrame:
    """Return the models that are validated, the recommended one first, the others by their error.

    Recommended is that with the fewest parameters of those with about the least error, which a
    sample does not tell apart.
    """
    known = table[table["validation_error"].notna()]
    known = known.sort_values(["validation_error", "parameters"], kind="stable")
    equal = known[
        known["validation_error"] <= MAX_EQUAL_ERROR_RATIO * known["validation_error"].min()
    ]
    best = equal.sort_values("parameters", kind="stable").head(1)
    return pd.concat([best, known.drop(best.index)])


def shown_models_table(judged: pd.DataFrame) -> pd.DataFrame:
    """Return ranked models, if there are any, as their page shows them.

    Errors are beside the recommended one's.
    """
    times = judged["validation_error"] / judged["validation_error"].head(1).min()
    others = [f"{ratio:.3g} times the error" for ratio in times[1:]]
    regions = zip(judged["coverage_min"], judged["coverage_min_region"], strict=True)
    judged = judged.assign(
        verdict=["recommended", *others][: len(judged)],
        error_95_percent=[
            f"{error_text(error)} %" + f", {error_text(own)} % without the scan" * (own < error)
            for error, own in zip(
                judged["error_95_percent"], judged["error_95_without_scan_percent"], strict=True
            )
        ],
        least_coverage=[f"{percent_text(least)}, {region}" for least, region in regions],
        validation_worst_n=judged["validation_worst_n"].map("{:.3g}".format),
    )
    return readable_table(judged[list(SHOWN_COLUMN_TITLES)]).set_axis(
        [*SHOWN_COLUMN_TITLES.values()], axis="columns"
    )


def _parameters_with_intervals(
    results: Results, space: str, fits: Sequence[FittedModel]
) -> pd.DataFrame:
    """Return the parameters of fits with their intervals; missing where an end is open."""
    plan = results.folder / f"simulations/{'screen' if space == 'two_factor' else space}"
    forces, rows = read_ok_forces(plan / "forces.csv"), []
    factors = factors_of_table(forces, limits=plan / "limits.csv")
    force_n = forces["force_n"].to_numpy()
    for fit in fits:
        if 0 < len(fit.theta) < len(factors):
            theta = local_fit_theta(fit.force_model, factors, force_n, fit.theta)
            ranges = parameter_ranges(fit.force_model, factors, force_n, theta)
            rows += [{"model": fit.model} | each.to_dict() for each in ranges]
    table = pd.DataFrame(rows, columns=["model", "name", "unit", "estimate", "lower", "upper"])
    powers = {"**2": "²", "**3": "³", "**4": "⁴", "**": "^"}
    for written, shown in powers.items():
        table["unit"] = table["unit"].str.replace(written, shown)
    return table.rename(columns={"name": "parameter", "lower": "lower_end", "upper": "upper_end"})


def compare_candidates(results: Results, space: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The candidates of a space, columns MODEL_COLUMNS, and their errors at each ranking point.

    A model that cannot be validated keeps its row, with the reason in ``note``.

    Raises InputError for a file that is missing or lacks what it must have.
    """
    sample, factors = results.validation_sample(space)
    half = ranking_points_mask(len(sample))
    known = half & (sample["status"] == "ok").to_numpy()
    factors, forces = factors.take(known), sample[known].reset_index(drop=True)
    scenes = forces[columns_in_table_form(SCENE_COLUMNS, forces)]
    no_force = int(half.sum() - known.sum())
    rows, errors = [], [scenes.iloc[:0].assign(model="", relative_error=np.nan)]
    for name in results.config.comparison.names_of_space(space):
        path = results.candidate_fit_file(space, name)
        values = read_json(path)
        try:
            row, relative = _model_row_and_errors(
                fit_from_values(values, source=path), factors, forces
            )
        except InputError as error:
            rows.append({"model": name, "note": str(values.get("not_supported", error))})
            continue
        rows.append(row | {"validation_failed": no_force})
        errors.append(scenes.assign(model=name, relative_error=relative))
    table = pd.DataFrame(rows, columns=list(MODEL_COLUMNS)).astype(
        dict.fromkeys(COUNT_COLUMNS, "Int64")
    )
    return table, pd.concat(errors[1:] or errors, ignore_index=True)


def _model_row_and_errors(
    fit: FittedModel, factors: Factors, forces: pd.DataFrame
) -> tuple[dict[str, Any], np.ndarray]:
    """A model's row, and its relative error at each point.

    Raises InputError where it cannot be validated.
    """
    model = fit.force_model
    if fit.prediction_interval is None:
        raise InputError("not validated: fit it with a validation sample")
    check_columns_known(model, factors)
    predicted = model.evaluate(fit.theta, factors)
    if undefined := int(np.sum(~np.isfinite(predicted))):
        raise InputError(f"undefined at {undefined} points of the validation sample")
    sizes = error_statistics(model_n=predicted, simulation_n=forces["force_n"])
    least = min(fit.prediction_interval.coverage, key=lambda region: region["coverage"])
    cross = fit.cross_validation
    error_95_percent = 100 * np.median(
        fit.prediction_interval.error_n(predicted) / np.abs(predicted)
    )
    row = {
        "model": fit.model,
        "parameters": len(fit.theta),
        "fit_points": fit.points,
        "fit_error": fit.global_error,
        "cv_error": np.nan if cross is None else cross["global_error"],
        "validation_points": len(forces),
        "validation_error": sizes["global_error"],
        "validation_worst_relative": sizes["largest_relative"],
        "validation_worst_n": sizes["largest_n"],
        "error_95_percent": error_95_percent,
        "error_95_without_scan_percent": error_95_percent - 100 * fit.profile_uncertainty,
        "coverage": fit.prediction_interval.mean_coverage,
        "coverage_min": least["coverage"],
        "coverage_min_region": f"{least['third']} third of the {COLUMNS[least['quantity']].label}",
        "expression": model.formula_text,
        "about": model.about or getattr(fit, "about", ""),
        "note": "",
    }
    return row, relative_errors(model_n=predicted, simulation_n=forces["force_n"])


def recommendation_table(results: Results) -> pd.DataFrame:
    """The best model of each space, and the amplitude that it needs at each position.

    Recommended is the first of ``ranked_models`` on the half of the validation sample that ranks.
    ``worst_error`` is the largest
    relative error at any simulation of RECOMMENDATION_PLANS, fitted or not. The amplitude gives the
    study's target force at its gap (section ``extrapolation``). One empty row where no model can be
    validated.
    """
    forces = {
        plan: read_forces(results.folder / f"simulations/{plan}/forces.csv").query("status == 'ok'")
        for plan in RECOMMENDATION_PLANS
    }
    rows = [
        row for space in FACTOR_SPACE_NAMES for row in _recommendation_rows(results, space, forces)
    ]
    return pd.DataFrame(rows or [dict.fromkeys(RECOMMENDATION_COLUMNS)])


def missing_amplitude_text(table: pd.DataFrame) -> str:
    """Return a sentence where no recommended model has an amplitude; empty where one has."""
    first = table.iloc[0]
    if pd.isna(first["model"]) or table["hv_m"].notna().any():
        return ""
    return (
        f"no recommended model gives {first['force_n']:g} N at h0 = {1e6 * first['h0_m']:g} µm by "
        "an amplitude below contact; choose a smaller extrapolation.force or extrapolation.h0"
    )


def rows_of_extreme_amplitudes(table: pd.DataFrame) -> pd.DataFrame:
    """Return of each space the position with the least and that with the largest amplitude.

    The last is one without an amplitude where there is any.
    """
    spaces = [rows.sort_values("hv_m") for _, rows in table.groupby("space", sort=False)]
    return pd.concat([rows.iloc[:: max(1, len(rows) - 1)] for rows in spaces])


def _recommendation_rows(
    results: Results, space: str, forces: dict[str, pd.DataFrame]
) -> Iterator[dict[str, Any]]:
    """A space's model at its positions; nothing where none can be validated."""
    names = ("model", "parameters", "fit_points", "validation_points", "validation_error")
    table = results.table(f"models/{space}.csv", *names)
    judged = ranked_models(table)
    if judged.empty:
        return
    best = judged.iloc[0]
    fit = read_fit(results.candidate_fit_file(space, best["model"]))
    every = pd.concat(list(forces.values()), ignore_index=True)
    known = every[factors_of_table(every).phi_r_m == 0] if space == "two_factor" else every
    model_n = fit.force_model.evaluate(
        fit.theta, fit.with_asymptotic_forces(factors_of_table(known))
    )
    errors = ((model_n - known["force_n"]) / known["force_n"]).to_numpy()
    about = {
        "space": space,
        **{name: best[name] for name in names},
        "simulations": len(known),
        "worst_error": float(np.abs(errors).max()) if np.isfinite(errors).all() else np.inf,
    }
    target = results.config.extrapolation
    positions = forces[RECOMMENDATION_PLANS[0]][
        list(find_position_columns(every))
    ].drop_duplicates()
    if space == "two_factor":  # the centre alone: models know no other
        positions = pd.DataFrame([dict.fromkeys(find_position_columns(every), 0.0)])
    for row in positions.sort_values(list(positions.columns)).to_dict("records"):
        position = {str(name): float(value) for name, value in row.items()}
        at = Factors.of(h0_m=target.h0_m, hv_m=target.hv_m, **position)
        amplitude = amplitude_row(fit, at, force_n=target.force_n)
        yield {**about, "h0_m": target.h0_m, **position, **amplitude}


def refine_page(results: Results, *, space: str) -> Page:
    """A row for each model that was refined, and what its refinement ended with.

    The held-out points are the space's validation sample.

    Raises InputError for a file that is missing or lacks what it must have.
    """
    sample, factors = results.validation_sample(space)
    known = (sample["status"] == "ok").to_numpy()
    force_n, factors = sample["force_n"].to_numpy()[known], factors.take(known)
    rows, reasons, profile_uncertainty = [], {}, 0.0
    for name in results.config.refine.names_of_space(space):
        folder = f"refine/{space}/{name}"
        verdict = results.read_json_file(f"{folder}/verdict.json")
        if "not_supported" in verdict:
            unknown = {"parameters": None, "verdict": "not supported", "simulations": None}
            rows.append({"model": verdict["model"], **unknown})
            reasons[verdict["model"]] = ("not supported", f"{verdict['not_supported']}.")
            continue
        fit = read_fit(results.folder / folder / "fit.json")
        profile_uncertainty = max(profile_uncertainty, fit.profile_uncertainty)
        rows.append(_refinement_row(results.folder / folder, verdict, fit, factors, force_n))
        reasons[verdict["model"]] = (
            verdict["verdict"],
            f"{verdict['reason']}. {verdict['error_by_region_text']} "
            f"(by {verdict['errors_mapped_by']}).",
        )
    table = pd.DataFrame(rows)
    refined = table[table["verdict"] != "not supported"]
    values = {
        "points": len(force_n),
        "reasons": reasons,
        "profile_uncertainty": profile_uncertainty,
        "shown": readable_table(refined),
    }
    return Page(values, {"table": table})


def _refinement_row(
    folder: Path,
    verdict: Mapping[str, Any],
    fit: FittedModel,
    factors: Factors,
    force_n: np.ndarray,
) -> dict[str, Any]:
    """Return the estimates of a refinement and the errors at held-out points."""
    model, estimated = fit.force_model, verdict["estimated"]
    check_columns_known(model, factors)
    error = model.evaluate(fit.theta, factors) - force_n
    best = model.evaluate(np.array(verdict["theta_of_all_points"]), factors) - force_n
    size_n = np.linalg.norm(force_n)
    share = np.nan  # no interval: the design does not settle the parameters
    if (lack_of_fit_n := verdict["lack_of_fit_n"]) is not None:
        quantile = float(scipy.special.stdtrit(verdict["verification_points"], 0.975))
        allowed_n = (
            quantile * lack_of_fit_n * np.sqrt(1 + _variance_over_lack_of_fit(folder, fit, factors))
        )
        share = float(np.mean(np.abs(error) <= allowed_n))
    return {
        "model": model.name,
        "parameters": len(fit.theta),
        "verdict": verdict["verdict"],
        "simulations": verdict["simulations"],
        "estimated_global_error": estimated["global_error"],
        "estimated_global_upper": estimated["global_upper"],
        "held_out_global_error": float(np.linalg.norm(error) / size_n),
        "held_out_global_error_all_points": float(np.linalg.norm(best) / size_n),
        "estimated_worst_error": estimated["worst_error"],
        "held_out_worst_error": float(np.abs(error).max() / np.sqrt(np.mean(force_n**2))),
        "held_out_points": len(force_n),
        "fraction_in_interval": share,
    }


def _variance_over_lack_of_fit(folder: Path, fit: FittedModel, held_out: Factors) -> Any:
    """Variance of a refined model's force at held-out points over that of its lack of fit."""
    if not fit.theta:
        return 0.0
    own = read_ok_forces(folder / "forces.csv")
    at = factors_of_table(own, limits=folder / "limits.csv")
    design = at.take(own["point_id"].str.startswith("design").to_numpy())
    slopes = (fit.force_model.gradient(fit.theta, points) for points in (design, held_out))
    # The sensitivity is f' (F'F/n)^-1 f / p.
    return sensitivity(*slopes) * len(fit.theta) / len(design)
