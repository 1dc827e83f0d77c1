"""D-optimal designs with a certificate, and how good other plans are beside them.

  squeezefilm optimal FIT.json --forces FORCES.csv --limits LIMITS.csv --config C.yaml \\
      --plans NAME=SCENES.csv … --patterns DESIGN.json --existing SCENES.csv \\
      --output DESIGNS.csv --efficiencies PLANS.csv --sensitivity MAP.csv --summary SUMMARY.json

The model is FIT.json's, FORCES.csv what it was fitted to: they give the parameters, and how far
these can go. DESIGNS.csv has these designs, all certified by the equivalence theorem:

  local      the best weights of points anywhere in the space, for the fitted parameters
  bayesian   for the mean over the parameter vectors at the ends of the parameters' ranges
  maximin    for the worst of these vectors
  exact-N    the best N points, each once and apart from the others
  augmented  the points of --existing and the best ones to add to them

PLANS.csv has the D-efficiency of these and of every plan given, with a lower bound that does not
need the best design; MAP.csv is what the figure `sensitivity` is drawn from.
"""

import argparse
from collections.abc import Sequence

import numpy as np
import pandas as pd

from squeezefilm.config.loading import load_config
from squeezefilm.io.errors import InputError, naming
from squeezefilm.io.sources import parse_sources
from squeezefilm.io.tables import (
    read_json,
    read_ok_forces,
    read_scenes,
    write_json,
    write_table,
)
from squeezefilm.models.data import factors_of
from squeezefilm.models.fit_file import read_fit
from squeezefilm.models.force_model import check_columns
from squeezefilm.studies.tasks.optimal_designs import (
    FittedSpace,
    efficiencies,
    optimal_designs,
    sensitivity_map,
    summary_of,
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument(
        "--forces", required=True, metavar="FORCES.csv", help="what it was fitted to"
    )
    parser.add_argument("--limits", metavar="LIMITS.csv", help="physics limits of the same scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--plans", nargs="*", default=[], metavar="NAME=SCENES.csv")
    parser.add_argument(
        "--patterns", metavar="DESIGN.json", help="patterns of `squeezefilm design`"
    )
    parser.add_argument("--existing", metavar="SCENES.csv", help="points to add to")
    parser.add_argument("--output", required=True, metavar="DESIGNS.csv", help="designs to write")
    parser.add_argument("--efficiencies", required=True, metavar="PLANS.csv", help="table to write")
    parser.add_argument("--sensitivity", required=True, metavar="MAP.csv", help="figure's table")
    parser.add_argument("--summary", required=True, metavar="SUMMARY.json", help="certificates")


def run(options: argparse.Namespace) -> None:
    fit, forces = read_fit(options.fit), read_ok_forces(options.forces)
    config = load_config(options.config)
    names = [word.partition("=")[0] for word in options.plans]
    plans = parse_sources(options.plans, names=names, user="optimal")
    existing = None if options.existing is None else read_scenes(options.existing)
    with naming(options.fit):
        factors = factors_of(forces, limits=options.limits)
        check_columns(fit.force_model, factors)
        study = FittedSpace.of(fit, factors, forces["force_n"].to_numpy(), config=config)
        others = {name: study.space.points(read_scenes(path)) for name, path in plans.items()}
        if options.patterns:
            others |= _patterns(options.patterns, study.space.box.names)
        designs = optimal_designs(study, config["optimal"], existing=existing)
    table = efficiencies(study, designs, others)
    write_table(pd.concat([each.table for each in designs], ignore_index=True), options.output)
    write_table(table, options.efficiencies)
    write_table(sensitivity_map(study, designs[0]), options.sensitivity)
    write_json(summary_of(study, designs, table), options.summary)
    print(table[["plan", "points", "d_efficiency", "lower_bound"]].to_string(index=False))


def _patterns(path: str, names: Sequence[str]) -> dict[str, np.ndarray]:
    """The patterns that `squeezefilm design` found, by the search they come from."""
    values = read_json(path)
    found = {}
    for kind in ("scalings", "forms"):
        for search, patterns in values.get(kind, {}).items():
            for pattern in patterns:
                points = [[point[name] for name in names] for point in pattern["points"]]
                found[f"pattern {pattern['pattern']} ({search})"] = np.array(points)
    if not found:
        raise InputError(f"{path}: no patterns; give what `squeezefilm design` wrote")
    return found
