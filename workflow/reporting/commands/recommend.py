"""Recommend a model in each space, and the amplitude that it asks for at each position.

  squeezefilm recommend RESULTS --config C.yaml --forces PLAN=FORCES.csv … --output TABLE.csv

RESULTS is the study's folder, with the comparisons models/SPACE.csv and their fits. Recommended is
the model with the least global error on the half of the validation sample that ranks, that with
fewer parameters where two are the same. FORCES.csv are simulations beside it; the plan
`four_factor` has the positions. `worst_error` is the largest relative error at any of them, fitted
or not. A row for each space (the finger at the centre) and each position, with the amplitude that
gives the study's wanted force at its gap (section `extrapolation`) and its errors as `squeezefilm
working-point` has them; none where no model can be judged.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.config.loading import Config, load_config
from squeezefilm.io.positions import form_of
from squeezefilm.io.sources import parse_sources, read_columns
from squeezefilm.io.tables import read_forces, write_table
from squeezefilm.models.experiments import factors_of
from squeezefilm.models.fitted import FittedModel, read_fit
from squeezefilm.models.force_model import Factors
from squeezefilm.models.library import SPACES
from squeezefilm.models.validation import relative_errors
from squeezefilm.models.working_point import working_point

LEAST = ("space", "model", "validation_error", "h0_m", "x_m", "y_m", "force_n")
"""Columns of a table with one empty row: no model can be judged."""
COLUMNS = (
    "space",
    "model",
    "parameters",
    "validation_points",
    "validation_error",
    "simulations",
    "worst_error",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="the study's results")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--forces", nargs="+", required=True, metavar="PLAN=FORCES.csv")
    parser.add_argument("--output", required=True, metavar="TABLE.csv", help="table to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    plans = [word.partition("=")[0] for word in options.forces]
    paths = parse_sources(options.forces, names=plans, user="recommend")
    forces = {plan: read_forces(path).query("status == 'ok'") for plan, path in paths.items()}
    rows = [row for space in SPACES for row in _rows(space, options.results, config, forces)]
    write_table(pd.DataFrame(rows or [dict.fromkeys(LEAST)]), options.output)


def _rows(
    space: str, results: Path, config: Config, forces: dict[str, pd.DataFrame]
) -> Iterator[dict[str, Any]]:
    """A space's model at its positions; nothing where the study has not compared any there."""
    path = results / "models" / f"{space}.csv"
    if not path.exists():
        return
    table = read_columns(
        path, columns=("model", "parameters", "validation_points", "validation_error")
    )
    judged = table[table["validation_error"].notna()]
    if judged.empty:
        return
    best = judged.sort_values(["validation_error", "parameters"], kind="stable").iloc[0]
    fit = read_fit(results / "models" / space / f"{best['model']}.json")
    every = pd.concat(list(forces.values()), ignore_index=True)
    known = every[factors_of(every).phi_r_m == 0] if space == "two_factor" else every
    about = {
        "space": space,
        **{name: best[name] for name in COLUMNS[1:-2]},
        "simulations": len(known),
        "worst_error": _worst(fit, known),
    }
    wanted = config["extrapolation"]
    for place in _places(space, forces.get("four_factor", every)):
        at = Factors.of(h0_m=wanted["h0_m"], hv_m=wanted["hv_m"], **place)
        found = working_point(fit, at, force_n=wanted["force_n"])
        yield {**about, "h0_m": wanted["h0_m"], **place, **found}


def _worst(fit: FittedModel, table: pd.DataFrame) -> float:
    """The largest relative error at simulations; infinite where the model is undefined at one."""
    model_n = fit.force_model.evaluate(fit.theta, fit.complete(factors_of(table)))
    if not np.isfinite(model_n).all():
        return float("inf")
    return float(np.abs(relative_errors(model_n=model_n, simulation_n=table["force_n"])).max())


def _places(space: str, table: pd.DataFrame) -> list[dict[str, float]]:
    """The positions of a plan; the centre alone where models know no other."""
    names = form_of(table)
    if space == "two_factor":
        return [dict.fromkeys(names, 0.0)]
    positions = table[list(names)].drop_duplicates().sort_values(list(names))
    return [
        {str(key): float(value) for key, value in row.items()}
        for row in positions.to_dict("records")
    ]
