"""What refinements estimated of their models' errors, beside points that they have never seen."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import scipy

from reporting.notes import VERDICTS
from reporting.pages import Page, readable
from reporting.results import Results
from squeezefilm.designs.optimal import sensitivity
from squeezefilm.models.data import Factors, factors_of
from squeezefilm.models.fit_file import FittedModel, read_fit
from squeezefilm.models.force_model import check_columns
from squeezefilm.tables import read_ok_forces

FIRST = ("model", "parameters", "verdict", "simulations")


def refine_page(results: Results, *, space: str) -> Page:
    """A row for each model that was refined, and what its refinement ended with.

    The unseen points are the space's validation sample.

    Raises InputError for a file that is missing or lacks what it must have.
    """
    sample, factors = results.sample(space)
    known = (sample["status"] == "ok").to_numpy()
    force_n, factors = sample["force_n"].to_numpy()[known], factors.take(known)
    rows, reasons, profile_uncertainty = [], {}, 0.0
    for name in results.config["refine"][space]:
        folder = results.folder / f"refine/{space}/{name}"
        verdict = results.summary(f"refine/{space}/{name}/verdict.json")
        if "refused" in verdict:
            rows.append({"model": verdict["model"], "verdict": "left out"})
            reasons[verdict["model"]] = ("left out", f"{verdict['refused']}.")
            continue
        fit = read_fit(folder / "fit.json")
        profile_uncertainty = max(profile_uncertainty, fit.profile_uncertainty)
        rows.append(_row(folder, verdict, fit, factors, force_n))
        reasons[verdict["model"]] = (
            VERDICTS[verdict["verdict"]],
            f"{verdict['reason']}. {verdict['error_by_region_text']} "
            f"(by {verdict['errors_mapped_by']}).",
        )
    names = dict.fromkeys([*FIRST, *(name for row in rows for name in row)])
    table = pd.DataFrame(rows, columns=list(names))
    refined = table[table["verdict"] != "left out"]
    values = {
        "points": len(force_n),
        "reasons": reasons,
        "profile_uncertainty": profile_uncertainty,
        "shown": readable(refined.assign(verdict=refined["verdict"].map(VERDICTS))),
    }
    return Page(values, {"table": table})


def _row(
    folder: Path,
    verdict: Mapping[str, Any],
    fit: FittedModel,
    factors: Factors,
    force_n: np.ndarray,
) -> dict[str, Any]:
    model, estimated = fit.force_model, verdict["estimated"]
    check_columns(model, factors)
    error = model.evaluate(fit.theta, factors) - force_n
    best = model.evaluate(np.array(verdict["theta_of_all_points"]), factors) - force_n
    size_n = np.linalg.norm(force_n)
    return {
        "model": model.name,
        "parameters": len(fit.theta),
        "verdict": verdict["verdict"],
        "simulations": verdict["simulations"],
        "estimated_global_error": estimated["global_error"],
        "estimated_global_upper": estimated["global_upper"],
        "unseen_global_error": float(np.linalg.norm(error) / size_n),
        "unseen_global_error_of_all_points": float(np.linalg.norm(best) / size_n),
        "estimated_worst_error": estimated["worst_error"],
        "unseen_worst_error": float(np.abs(error).max() / np.sqrt(np.mean(force_n**2))),
        "unseen_points": len(force_n),
        "share_in_interval": _coverage(folder, verdict, fit, factors, error),
    }


def _coverage(
    folder: Path,
    verdict: Mapping[str, Any],
    fit: FittedModel,
    factors: Factors,
    error_n: np.ndarray,
) -> float:
    """Share of the unseen points whose error is within their own 95 % interval.

    NaN where there are none: the design does not settle the parameters.
    """
    if verdict["lack_of_fit_n"] is None:
        return float("nan")
    spread, model = np.zeros(len(error_n)), fit.force_model
    if fit.theta:
        own = read_ok_forces(folder / "forces.csv")
        at = factors_of(own, limits=folder / "limits.csv")
        design = at.take(own["point_id"].str.startswith("design").to_numpy())
        f = model.gradient(fit.theta, design)
        # The sensitivity is f' (F'F/n)^-1 f / p.
        scale = len(fit.theta) / len(design)
        spread = sensitivity(f, model.gradient(fit.theta, factors)) * scale
    quantile = float(scipy.special.stdtrit(verdict["verification_points"], 0.975))
    allowed_n = quantile * verdict["lack_of_fit_n"] * np.sqrt(1 + spread)
    return float(np.mean(np.abs(error_n) <= allowed_n))
