"""Compare fitted models: errors on their points, on points left out, and on control points.

  squeezefilm compare two_factor FIT.json … --config C.yaml \\
      --forces FORCES.csv --limits LIMITS.csv \\
      --output TABLE.csv --report TABLE.md --errors ERRORS.csv

The candidates of the study's section `comparison` must be among the fits; they are shown in its
order. FORCES.csv has the control points, LIMITS.csv their physics limits; those that a model was
fitted to are left out. A model is not judged where most of them lie outside the points it was
fitted to. ERRORS.csv has the relative error of every model at every control point; a figure is
drawn from it.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reporting.pages.notes import percent, scan_note
from squeezefilm.io.atomic import write_text
from squeezefilm.io.errors import InputError
from squeezefilm.io.markdown import markdown_table
from squeezefilm.io.positions import form_of
from squeezefilm.io.tables import read_json, read_ok_forces, write_table
from squeezefilm.models.experiments import check_columns, factors_of
from squeezefilm.models.fitted import FittedModel, read_fit
from squeezefilm.models.force_model import Factors
from squeezefilm.models.validation import error_sizes, relative_errors
from squeezefilm.studies.config import load_config

SECTIONS = ("comparison",)
TITLES = {"two_factor": "the finger centred", "four_factor": "the finger anywhere on the surface"}
COLUMNS = (
    "model",
    "parameters",
    "fit_points",
    "fit_error",
    "left_out_error",
    "control_points",
    "control_error",
    "control_worst_relative",
    "control_worst_n",
    "expression",
    "about",
    "note",
)
NONE_JUDGED = {
    "model": "",
    **dict.fromkeys(("parameters", "control_error_percent", "h0_um", "hv_um"), np.nan),
    "relative_error_percent": np.nan,
}
HEADINGS = {
    "model": "model",
    "parameters": "parameters",
    "fit_error": "global error, fitted points",
    "left_out_error": "left out in turn",
    "control_error": "control points",
    "control_worst_relative": "largest relative error there",
    "about": "what it is",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("space", choices=TITLES, metavar="SPACE", help=" or ".join(TITLES))
    parser.add_argument("fits", nargs="+", metavar="FIT.json", help="fitted models")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--forces", required=True, metavar="FORCES.csv", help="control points")
    parser.add_argument("--limits", metavar="LIMITS.csv", help="physics limits of the same scenes")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="errors, to write")
    parser.add_argument("--report", required=True, metavar="TABLE.md", help="for people")
    parser.add_argument("--errors", required=True, metavar="ERRORS.csv", help="of each point")


def run(options: argparse.Namespace) -> None:
    candidates = load_config(options.config).only(SECTIONS)["comparison"][options.space]
    forces = read_ok_forces(options.forces)
    factors = factors_of(forces, limits=options.limits)
    paths = _in_order(options.fits, candidates)
    fits = [read_fit(path) for path in paths if "refused" not in read_json(path)]
    fitted = [fit.trust.was_fitted(factors) for fit in fits if fit.trust is not None]
    new = ~np.any([np.zeros(len(factors), bool), *fitted], axis=0)
    if not new.any():
        raise InputError(f"{options.forces}: every point was fitted, none is left to judge by")
    forces, factors = forces[new].reset_index(drop=True), factors.take(new)
    rows, errors = [], []
    for path in paths:
        row, error = _judged(path, factors, forces)
        rows.append(row)
        if error is not None:
            errors.append(error)
    table = pd.DataFrame(rows, columns=list(COLUMNS)).astype(
        {"parameters": "Int64", "fit_points": "Int64", "control_points": "Int64"}
    )
    scan_error = max((fit.scan_error for fit in fits), default=0.0)
    text = _report(table, space=options.space, points=len(forces), scan_error=scan_error)
    write_table(table, options.output)
    write_text(text, options.report)
    note = (
        f"Relative error of each model at {len(forces)} control simulations that it was not fitted "
        "to; above each panel the number of parameters and the global error there."
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
    path: str, factors: Factors, forces: pd.DataFrame
) -> tuple[dict[str, Any], pd.DataFrame | None]:
    """A model's row, and its error at each control point, unless it cannot be judged there."""
    values = read_json(path)
    name = str(values.get("model", Path(path).stem))
    try:
        fit = read_fit(path)
        model = fit.force_model
        check_columns(model, factors)
        predicted = model.evaluate(fit.theta, factors)
        undefined = int(np.sum(~np.isfinite(predicted)))
        if undefined:
            raise InputError(f"undefined at {undefined} control points")
        errors = error_sizes(model_n=predicted, simulation_n=forces["force_n"])
    except InputError as error:
        return {"model": name, "note": str(values.get("refused", error))}, None
    outside = _outside(fit, factors)
    if 2 * outside > len(forces):
        note = f"{outside} of {len(forces)} control points lie outside the points it was fitted to"
        return {"model": name, "note": note}, None
    relative = relative_errors(model_n=predicted, simulation_n=forces["force_n"])
    row = {
        "model": name,
        "parameters": len(fit.theta),
        "fit_points": fit.points,
        "fit_error": fit.global_error,
        "left_out_error": _left_out(fit),
        "control_points": len(forces),
        "control_error": errors["global_error"],
        "control_worst_relative": errors["largest_relative"],
        "control_worst_n": errors["largest_n"],
        "expression": model.expression,
        "about": model.about or values.get("about", ""),
        "note": f"{outside} control points lie outside the fitted ones" if outside else "",
    }
    map_ = pd.DataFrame(
        {
            "model": name,
            "parameters": len(fit.theta),
            "control_error_percent": 100 * errors["global_error"],
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


def _outside(fit: FittedModel, factors: Factors) -> int:
    """How many points lie outside the ranges of the fitted ones, as far as the file tells."""
    return 0 if fit.trust is None else sum(map(bool, fit.trust.outside(factors)))


def _left_out(fit: FittedModel) -> float:
    return np.nan if fit.cross_validation is None else fit.cross_validation["global_error"]


def _report(table: pd.DataFrame, *, space: str, points: int, scan_error: float) -> str:
    """The table for people, the best on the control points first."""
    judged = table[table["control_error"].notna()].sort_values("control_error", kind="stable")
    shown = judged[list(HEADINGS)].copy()
    for name in ("fit_error", "left_out_error", "control_error", "control_worst_relative"):
        shown[name] = [percent(v) if np.isfinite(v) else "–" for v in judged[name].astype(float)]
    lines = [
        f"# Models compared, {TITLES[space]}, on {points} control points\n\n",
        "Global error is |model − simulation|/|simulation|. Points are left out in turn, a fifth "
        "at a time, and predicted by the model fitted to the rest. No model was fitted to the "
        "control points.\n\n",
        scan_note(scan_error),
        markdown_table(shown.rename(columns=HEADINGS)),
        "\nFormulas:\n\n",
        *(f"- {row.model}: `{row.expression}`\n" for row in judged.itertuples()),
    ]
    refused = table[table["control_error"].isna()]
    if len(refused):
        lines.append("\nNot judged:\n\n")
        lines += [f"- {row.model}: {row.note}\n" for row in refused.itertuples()]
    return "".join(lines)
