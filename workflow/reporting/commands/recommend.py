"""Recommend a model in each space, and the amplitude that it asks for at each position.

  squeezefilm recommend results/plate --output TABLE.csv

Recommended is the model with the least global error on the half of the validation sample that
ranks. `worst_error` is the largest relative error at any simulation of the validation samples and
the plan `four_factor`, fitted or not; that plan has the positions. The amplitude gives the study's
wanted force at its gap (section `extrapolation`), its errors are those of `squeezefilm
working-point`. The study's candidates must be compared (`snakemake models`).
"""

import argparse
from pathlib import Path

from reporting.models import recommend
from reporting.results import Results
from squeezefilm.tables import write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="the study's results")
    parser.add_argument("--config", metavar="CONFIG.yaml", help="the study, if not RESULTS' own")
    parser.add_argument("--output", metavar="TABLE.csv", help="table to write, else it is shown")


def run(options: argparse.Namespace) -> None:
    table = recommend(Results.of(options.results, options.config))
    if options.output:
        write_table(table, options.output)
    else:
        print(table.to_string(index=False))
