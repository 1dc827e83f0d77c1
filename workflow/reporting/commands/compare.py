"""Compare fitted models: errors on their points, on points left out, and on a validation sample.

  squeezefilm compare two_factor FIT.json … --config C.yaml \\
      --forces FORCES.csv --limits LIMITS.csv \\
      --output TABLE.csv --report TABLE.md --errors ERRORS.csv

The candidates of the study's section `comparison` must be among the fits; they are shown in its
order. FORCES.csv is the space's validation sample, LIMITS.csv has its physics limits: one half of
it ranks the models, the other calibrated their prediction intervals (`squeezefilm fit`). Points
that have no force are excluded from the errors and counted. ERRORS.csv has the relative error of
every model at every point of the half that ranks; a figure is drawn from it.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reporting.pages.notes import percent, scan_note
from squeezefilm.config.loading import load_config
from squeezefilm.io.atomic import write_text
from squeezefilm.io.errors import InputError
from squeezefilm.io.markdown import markdown_table
from squeezefilm.io.positions import form_of
from squeezefilm.io.tables import read_forces, read_json, write_table
from squeezefilm.models.error_by_region import QUANTITIES
from squeezefilm.models.experiments import check_columns, factors_of
from squeezefilm.models.fitted import FittedModel, read_fit
from squeezefilm.models.force_model import Factors
from squeezefilm.models.prediction_interval import ranking_half
from squeezefilm.models.validation import error_sizes, relative_errors

TITLES = {"two_factor": "the finger centred", "four_factor": "the finger anywhere on the surface"}
COLUMNS = (
    "model",
    "parameters",
    "fit_points",
    "fit_error",
    "left_out_error",
    "validation_points",
    "validation_failed",
    "validation_error",
    "validation_worst_relative",
    "validation_worst_n",
    "error_95_percent",
    "coverage",
    "coverage_least",
    "coverage_least_in",
    "expression",
    "about",
    "note",
)
NONE_JUDGED = {
    "model": "",
    **dict.fromkeys(("parameters", "validation_error_percent", "h0_um", "hv_um"), np.nan),
    "relative_error_percent": np.nan,
}
HEADINGS = {
    "model": "model",
    "parameters": "parameters",
    "fit_error": "global error, fitted points",
    "left_out_error": "left out in turn",
    "validation_error": "validation sample",
    "validation_worst_relative": "largest relative error there",
    "error_95_percent": "95 % error, median",
    "coverage": "inside it",
    "coverage_least": "least, by region",
    "about": "what it is",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("space", choices=TITLES, metavar="SPACE", help=" or ".join(TITLES))
    parser.add_argument("fits", nargs="+", metavar="FIT.json", help="fitted models")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--forces", required=True, metavar="FORCES.csv", help="validation sample")
    parser.add_argument("--limits", metavar="LIMITS.csv", help="physics limits of the same scenes")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="errors, to write")
    parser.add_argument("--report", required=True, metavar="TABLE.md", help="for people")
    parser.add_argument("--errors", required=True, metavar="ERRORS.csv", help="of each point")


def run(options: argparse.Namespace) -> None:
    candidates = load_config(options.config)["comparison"][options.space]
    sample = read_forces(options.forces)
    factors = factors_of(sample, limits=options.limits)
    known = ranking_half(len(sample)) & (sample["status"] == "ok").to_numpy()
    failed = int(ranking_half(len(sample)).sum() - known.sum())
    forces, factors = sample[known].reset_index(drop=True), factors.take(known)
    rows, errors = [], []
    for path in _in_order(options.fits, candidates):
        row, error = _judged(path, factors, forces, failed=failed)
        rows.append(row)
        if error is not None:
            errors.append(error)
    table = pd.DataFrame(rows, columns=list(COLUMNS)).astype(
        dict.fromkeys(
            ("parameters", "fit_points", "validation_points", "validation_failed"), "Int64"
        )
    )
    fits = [read_fit(path) for path in options.fits if "refused" not in read_json(path)]
    text = _report(table, space=options.space, fits=fits)
    write_table(table, options.output)
    write_text(text, options.report)
    note = (
        f"Relative error of each model at {len(forces)} independent simulations, uniform over the "
        "declared space, that no fit used; above each panel the number of parameters and the "
        "global error there."
    )
    # A row without a model where none can be judged: the figure says so.
    drawn = pd.concat(errors, ignore_index=True) if errors else pd.DataFrame([NONE_JUDGED])
    write_table(drawn.assign(note=note), options.errors)
    print(text)


def _in_order(paths: Sequence[str], candidates: Sequence[str]) -> list[str]:
    """The files of the candidates, by the models that they name."""
    by_name = {str(read_json(path).get("model")): path for path in paths}
    missing = [name for name in candidates if name.replace("-", "_") not in by_name]
    if missing:
        raise InputError(f"compare: no fit of {', '.join(missing)} is given")
    return [by_name[name.replace("-", "_")] for name in candidates]


def _judged(
    path: str, factors: Factors, forces: pd.DataFrame, *, failed: int
) -> tuple[dict[str, Any], pd.DataFrame | None]:
    """A model's row, and its error at each point of the ranking half, unless it is not offered."""
    values = read_json(path)
    name = str(values.get("model", Path(path).stem))
    try:
        fit = read_fit(path)
        model = fit.force_model
        if fit.interval is None:
            raise InputError("not validated: fit it with a validation sample")
        check_columns(model, factors)
        predicted = model.evaluate(fit.theta, factors)
        undefined = int(np.sum(~np.isfinite(predicted)))
        if undefined:
            raise InputError(f"undefined at {undefined} points of the validation sample")
        errors = error_sizes(model_n=predicted, simulation_n=forces["force_n"])
    except InputError as error:
        return {"model": name, "note": str(values.get("refused", error))}, None
    relative = relative_errors(model_n=predicted, simulation_n=forces["force_n"])
    least = min(fit.interval.coverage, key=lambda region: region["coverage"])
    row = {
        "model": name,
        "parameters": len(fit.theta),
        "fit_points": fit.points,
        "fit_error": fit.global_error,
        "left_out_error": _left_out(fit),
        "validation_points": len(forces),
        "validation_failed": failed,
        "validation_error": errors["global_error"],
        "validation_worst_relative": errors["largest_relative"],
        "validation_worst_n": errors["largest_n"],
        "error_95_percent": 100
        * float(np.median(fit.interval.error_n(predicted) / np.abs(predicted))),
        "coverage": fit.interval.mean_coverage,
        "coverage_least": least["coverage"],
        "coverage_least_in": f"{least['third']} third of the {QUANTITIES[least['quantity']]}",
        "expression": model.expression,
        "about": model.about or values.get("about", ""),
        "note": "",
    }
    map_ = pd.DataFrame(
        {
            "model": name,
            "parameters": len(fit.theta),
            "validation_error_percent": 100 * errors["global_error"],
            "h0_um": 1e6 * forces["h0_m"],
            "hv_um": 1e6 * forces["hv_m"],
            **_places(forces),
            "relative_error_percent": 100 * relative,
        }
    )
    return row, map_


def _places(forces: pd.DataFrame) -> dict[str, pd.Series]:
    """The finger's positions, lengths in mm."""
    return {
        f"{name}m" if name.endswith("_m") else name: forces[name]
        * (1e3 if name.endswith("_m") else 1.0)
        for name in form_of(forces)
    }


def _left_out(fit: FittedModel) -> float:
    return np.nan if fit.cross_validation is None else fit.cross_validation["global_error"]


def _report(table: pd.DataFrame, *, space: str, fits: Sequence[FittedModel]) -> str:
    """The table for people, the best on the validation sample first."""
    judged = table[table["validation_error"].notna()].sort_values("validation_error", kind="stable")
    shown = judged[list(HEADINGS)].copy()
    for name in ("fit_error", "left_out_error", "validation_error", "validation_worst_relative"):
        shown[name] = [percent(v) if np.isfinite(v) else "–" for v in judged[name].astype(float)]
    shown["error_95_percent"] = [percent(v / 100) for v in judged["error_95_percent"]]
    shown["coverage"] = [f"{v:.1%}" for v in judged["coverage"]]
    shown["coverage_least"] = [
        f"{row.coverage_least:.1%} ({row.coverage_least_in})" for row in judged.itertuples()
    ]
    intervals = [fit.interval for fit in fits if fit.interval is not None]
    lines = [
        f"# Models compared, {TITLES[space]}\n\n",
        "Global error is |model − simulation|/|simulation|. Points are left out in turn, a fifth "
        "at a time, and predicted by the model fitted to the rest. One half of the validation "
        "sample ranks the models, the other calibrates their 95 % errors; *inside it* is the share "
        "of the first half within them, in all and in the third of a factor's range where it is "
        "least.\n\n",
        *(f"{interval.statement}\n\n" for interval in intervals[:1]),
        scan_note(max((fit.profile_uncertainty for fit in fits), default=0.0)),
        markdown_table(shown.rename(columns=HEADINGS)),
        "\nFormulas:\n\n",
        *(f"- {row.model}: `{row.expression}`\n" for row in judged.itertuples()),
    ]
    refused = table[table["validation_error"].isna()]
    if len(refused):
        lines.append("\nNot validated:\n\n")
        lines += [f"- {row.model}: {row.note}\n" for row in refused.itertuples()]
    return "".join(lines)
