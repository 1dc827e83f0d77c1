"""Find the points at which simulations teach most about a fitted model: D-optimal designs.

  squeezefilm design two-factor FIT.json --config C.yaml \\
      --output DESIGN.csv --searches SEARCHES.csv --summary DESIGN.json
  squeezefilm design four-factor FIT.json --config C.yaml \\
      --output DESIGN.csv --distinct DISTINCT.csv --searches SEARCHES.csv --summary DESIGN.json

Two factors: triplets by criterion (12), searched in each scaling of the distances; the patterns
found with the study's own scaling are united and extended to the wanted number of points. Four
factors: the determinant alone (DESIGN.csv), and once more with the points physically distinct
(DISTINCT.csv). SEARCHES.csv has every point of every search, DESIGN.json the patterns and their
efficiency against an optimum found by exchange on a fine grid.
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.io.errors import InputError, naming
from squeezefilm.io.tables import write_json, write_table
from squeezefilm.models.fit_file import read_fit
from squeezefilm.studies.tasks.paper_designs import four_factor_designs, two_factor_designs

MODELS = ("two-factor", "four-factor")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", choices=MODELS, help=" or ".join(MODELS), metavar="MODEL")
    parser.add_argument("fit", metavar="FIT.json", help="the fitted model")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="DESIGN.csv", help="the design")
    parser.add_argument("--distinct", metavar="DISTINCT.csv", help="the one of distinct scenes")
    parser.add_argument("--processes", type=int, default=1, help="to spread the searches over")
    parser.add_argument("--searches", required=True, metavar="SEARCHES.csv", help="all searches")
    parser.add_argument("--summary", required=True, metavar="DESIGN.json", help="what was found")


def run(options: argparse.Namespace) -> None:
    if (options.distinct is not None) != (options.model == "four-factor"):
        raise InputError("--distinct belongs to the four-factor design, and to no other")
    config = load_config(options.config)
    fit = read_fit(options.fit)
    if fit.model != options.model.replace("-", "_"):
        raise InputError(f"{options.fit}: a fit of the model {fit.model}, not of {options.model}")
    designs = two_factor_designs if options.model == "two-factor" else four_factor_designs
    with naming(options.fit):
        found = designs(fit, config, processes=options.processes)
    for path, table in zip((options.output, options.distinct), found.tables, strict=False):
        write_table(table, path)
    write_table(found.searches, options.searches)
    write_json(found.summary, options.summary)
