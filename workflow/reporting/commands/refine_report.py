"""Compare what refinements estimated of their models' errors with points they have never seen.

  squeezefilm refine-report MODEL_FOLDER … --forces FORCES.csv --limits LIMITS.csv \\
      --output TABLE.csv --report TABLE.md --figure FIGURE.csv

A MODEL_FOLDER holds what `squeezefilm refine` wrote: rounds.csv, forces.csv, limits.csv, where.csv,
fit.json and verdict.json; a model that it left out is named, with the reason. FORCES.csv is the
space's validation sample, LIMITS.csv has its physics limits.
FIGURE.csv is what the figure `refine` is drawn from.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from reporting.pages.notes import percent, scan_note
from squeezefilm.designs.optimal import sensitivity
from squeezefilm.io.atomic import write_text
from squeezefilm.io.markdown import markdown_table
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import (
    ROUND_COLUMNS,
    WHERE_COLUMNS,
    read_forces,
    read_json,
    read_ok_forces,
    write_table,
)
from squeezefilm.models.data import Factors, factors_of
from squeezefilm.models.fit_file import FittedModel, read_fit
from squeezefilm.models.force_model import ExpressionModel, check_columns

TABLE_COLUMNS = (
    "model",
    "parameters",
    "verdict",
    "simulations",
    "estimated_global_error",
    "estimated_global_upper",
    "unseen_global_error",
    "unseen_global_error_of_all_points",
    "estimated_worst_error",
    "unseen_worst_error",
    "unseen_points",
    "share_in_interval",
)
FIGURE_COLUMNS = (
    "layer",
    "simulations",
    "global_error_percent",
    "global_lower_percent",
    "global_upper_percent",
    "worst_error_percent",
    "h0_um",
    "hv_um",
    "x_mm",
    "y_mm",
    "relative_error_percent",
    "model",
    "verdict",
)
VERDICTS = {
    "reached": "as good as wanted",
    "model": "limited by the model",
    "simulation": "limited by the simulations",
    "budget": "out of simulations",
    "left out": "left out",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folders", nargs="+", metavar="MODEL_FOLDER", help="of one model each")
    parser.add_argument("--forces", required=True, metavar="FORCES.csv", help="unseen points")
    parser.add_argument("--limits", required=True, metavar="LIMITS.csv", help="their limits")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")
    parser.add_argument("--report", required=True, metavar="TABLE.md", help="for people")
    parser.add_argument("--figure", required=True, metavar="FIGURE.csv", help="figure's table")


def run(options: argparse.Namespace) -> None:
    sample = read_forces(options.forces)
    known = (sample["status"] == "ok").to_numpy()
    unseen = sample[known]
    factors = factors_of(sample, limits=options.limits).take(known)
    rows, drawn, said = [], [], []
    folders = [Path(folder) for folder in options.folders]
    verdicts = [read_json(folder / "verdict.json") for folder in folders]
    fits = [
        read_fit(folder / "fit.json")
        for folder, verdict in zip(folders, verdicts, strict=True)
        if "refused" not in verdict
    ]
    profile_uncertainty = max((fit.profile_uncertainty for fit in fits), default=0.0)
    for folder, verdict in zip(folders, verdicts, strict=True):
        if "refused" in verdict:
            left_out = {"model": verdict["model"], "verdict": "left out"}
            rows.append(left_out)
            drawn.append(pd.DataFrame([{**left_out, "layer": "left out"}]))
            said.append(f"- **{verdict['model']}**, left out: {verdict['refused']}.\n")
            continue
        fit = read_fit(folder / "fit.json")
        row = _row(folder, verdict, fit, factors, unseen["force_n"].to_numpy())
        rows.append(row)
        drawn.append(_drawn(folder, verdict, row))
        said.append(
            f"- **{row['model']}**, {VERDICTS[row['verdict']]}: {verdict['reason']}. "
            f"{verdict['error_by_region_text']} (by {verdict['errors_mapped_by']}).\n"
        )
    table = pd.DataFrame(rows, columns=list(TABLE_COLUMNS))
    text = _report(table, said, points=len(unseen), profile_uncertainty=profile_uncertainty)
    note = (
        f"Estimates from verification points that are never fitted, with 95 % limits; stars: the "
        f"truth on {len(unseen)} simulations that no refinement used. Errors over the root mean "
        "square force. Maps: the best fit to all simulated points, circled."
    )
    if all("refused" in each for each in verdicts):
        note = "The physics limit, which these models need, does not hold all over the space."
    write_table(table, options.output)
    write_text(text, options.report)
    figure = pd.concat(drawn, ignore_index=True).reindex(columns=list(FIGURE_COLUMNS))
    write_table(figure.assign(note=note), options.figure)
    print(text)


def _row(
    folder: Path, verdict: dict[str, Any], fit: FittedModel, factors: Factors, force_n: np.ndarray
) -> dict[str, Any]:
    model = fit.force_model
    check_columns(model, factors)
    error = model.evaluate(fit.theta, factors) - force_n
    best = model.evaluate(np.array(verdict["theta_of_all_points"]), factors) - force_n
    estimated = verdict["estimated"]
    return {
        "model": model.name,
        "parameters": len(fit.theta),
        "verdict": verdict["verdict"],
        "simulations": verdict["simulations"],
        "estimated_global_error": estimated["global_error"],
        "estimated_global_upper": estimated["global_upper"],
        "unseen_global_error": float(np.linalg.norm(error) / np.linalg.norm(force_n)),
        "unseen_global_error_of_all_points": float(np.linalg.norm(best) / np.linalg.norm(force_n)),
        "estimated_worst_error": estimated["worst_error"],
        "unseen_worst_error": float(np.abs(error).max() / np.sqrt(np.mean(force_n**2))),
        "unseen_points": len(force_n),
        "share_in_interval": _coverage(folder, verdict, fit, model, factors, error),
    }


def _coverage(
    folder: Path,
    verdict: dict[str, Any],
    fit: FittedModel,
    model: ExpressionModel,
    factors: Factors,
    error_n: np.ndarray,
) -> float:
    """Share of the unseen points whose error is within their own 95 % interval.

    NaN where there are none: the design does not settle the parameters.
    """
    if verdict["lack_of_fit_n"] is None:
        return float("nan")
    spread = np.zeros(len(error_n))
    if fit.theta:
        own = read_ok_forces(folder / "forces.csv")
        at = factors_of(own, limits=folder / "limits.csv")
        design = at.take(own["point_id"].str.startswith("design").to_numpy())
        f = model.gradient(fit.theta, design)
        # The sensitivity is f' (F'F/n)^-1 f / p.
        scale = len(fit.theta) / len(design)
        spread = sensitivity(f, model.gradient(fit.theta, factors)) * scale
    quantile = float(stats.t.ppf(0.975, verdict["verification_points"]))
    return float(
        np.mean(np.abs(error_n) <= quantile * verdict["lack_of_fit_n"] * np.sqrt(1 + spread))
    )


def _drawn(folder: Path, verdict: dict[str, Any], row: dict[str, Any]) -> pd.DataFrame:
    """Rounds, truth, wanted errors, map and simulated points of one model, a layer each."""
    rounds = read_columns(folder / "rounds.csv", columns=ROUND_COLUMNS)
    where = read_columns(folder / "where.csv", columns=WHERE_COLUMNS)
    sample = where[where["layer"] == "sample"]
    simulated = read_ok_forces(folder / "forces.csv")
    percentages = {
        name: 100 * rounds[name].to_numpy(dtype=float) for name in ROUND_COLUMNS if "_" in name
    }
    estimates = pd.DataFrame(
        {"simulations": rounds["simulations"]}
        | {f"{name}_percent": values for name, values in percentages.items()}
    )
    wanted = verdict["wanted"]
    one = {
        "truth": (row["simulations"], row["unseen_global_error"], row["unseen_worst_error"]),
        "wanted": (row["simulations"], wanted["global_error"], wanted["worst_error"]),
    }
    points = [
        pd.DataFrame(
            {
                "layer": [layer],
                "simulations": [simulations],
                "global_error_percent": [100 * total],
                "worst_error_percent": [100 * worst],
            }
        )
        for layer, (simulations, total, worst) in one.items()
    ]
    error = 100 * sample["error_n"].to_numpy(dtype=float) / verdict["mean_force_n"]
    map_ = _places(sample).assign(layer="map", relative_error_percent=error)
    return pd.concat(
        [
            estimates.assign(layer="estimate"),
            *points,
            map_,
            _places(simulated).assign(layer="simulated"),
        ],
        ignore_index=True,
    ).assign(model=row["model"], verdict=VERDICTS[row["verdict"]])


def _places(table: pd.DataFrame) -> pd.DataFrame:
    at = factors_of(table)
    return pd.DataFrame(
        {
            "h0_um": 1e6 * table["h0_m"].to_numpy(dtype=float),
            "hv_um": 1e6 * table["hv_m"].to_numpy(dtype=float),
            "x_mm": 1e3 * at.x_m,
            "y_mm": 1e3 * at.y_m,
        }
    )


def _report(
    table: pd.DataFrame, said: list[str], *, points: int, profile_uncertainty: float
) -> str:
    table = table[table["verdict"] != "left out"]
    shown = pd.DataFrame(
        {
            "model": table["model"],
            "verdict": table["verdict"].map(VERDICTS),
            "simulations": table["simulations"],
            "global error, estimated": [
                f"{percent(value)} (below {percent(upper)})"
                for value, upper in zip(
                    table["estimated_global_error"], table["estimated_global_upper"], strict=True
                )
            ],
            "unseen points": [percent(value) for value in table["unseen_global_error"]],
            "fitted to all": [
                percent(value) for value in table["unseen_global_error_of_all_points"]
            ],
            "worst error, estimated": [
                "open" if pd.isna(value) else percent(value)
                for value in table["estimated_worst_error"]
            ],
            "worst of the unseen": [percent(value) for value in table["unseen_worst_error"]],
            "in their interval": [
                "none known" if pd.isna(value) else f"{value:.0%}"
                for value in table["share_in_interval"]
            ],
        }
    )
    return (
        f"# Refined models and {points} points that no refinement used\n\n"
        "Global error is |model − simulation|/|simulation|; the worst error is over the root mean "
        "square force. Estimates come from verification points that are simulated, counted and "
        "never fitted; *fitted to all* is the error on the unseen points of a fit that includes "
        "them. Simulations have no scatter: a 95 % limit is about where in the space one looks, "
        "not about noise.\n\n"
        + scan_note(profile_uncertainty)
        + (markdown_table(shown) if len(shown) else "No model could be refined.\n")
        + "\n"
        + "".join(said)
    )
