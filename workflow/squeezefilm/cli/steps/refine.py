"""Simulate, fit, judge, design, simulate …, until a model is good enough or cannot be.

  squeezefilm refine limit_1 --space four-factor --config C.yaml --rounds ROUNDS.csv \\
      --forces FORCES.csv --limits LIMITS.csv --fit FIT.json --where WHERE.csv --output VERDICT.json

The loop stops when the estimated errors over the space are below the wanted ones of the study's
section `refine`, or says what the limit is: the model, the simulations' own error, or the number
of simulations. Errors are estimated from verification points that are never fitted.

ROUNDS.csv has a row for each round, FORCES.csv every simulation (a point_id tells its kind and
round), LIMITS.csv the physics limits of the same scenes, FIT.json the fitted model with the range
of each parameter, WHERE.csv the model's error over the space, and VERDICT.json how it ended. With
--keep-going a model that needs the physics limits where they do not hold is left out before
anything is simulated: the two JSON files say why, and the tables are empty. --scan is what
`squeezefilm profile` says of a measured profile: part of the fit's error. --sample and
--sample-limits are the validation sample, as `squeezefilm fit` takes it.
"""

import argparse

import pandas as pd

from squeezefilm.config.loading import load_config
from squeezefilm.designs.sequential import Round
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import (
    FORCE_COLUMNS,
    LIMIT_COLUMNS,
    ROUND_COLUMNS,
    WHERE_COLUMNS,
    write_json,
    write_table,
)
from squeezefilm.models.force_model import SPACES, check_columns, model_named
from squeezefilm.studies.tasks.refined_model import SimulatedSpace, refined_model
from squeezefilm.studies.tasks.scan_share import scan_error_of
from squeezefilm.studies.tasks.validation_sample import add_sample_options, with_validation

TABLES = {
    "rounds": ROUND_COLUMNS,
    "forces": FORCE_COLUMNS,
    "limits": LIMIT_COLUMNS,
    "where": WHERE_COLUMNS,
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="of the library or the study")
    parser.add_argument("--space", default="four-factor", help="two-factor or four-factor")
    parser.add_argument("--scan", metavar="SUMMARY.json", help="of a measured profile")
    add_sample_options(parser)
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--rounds", required=True, metavar="ROUNDS.csv", help="what was estimated")
    parser.add_argument("--forces", required=True, metavar="FORCES.csv", help="what was simulated")
    parser.add_argument(
        "--limits", required=True, metavar="LIMITS.csv", help="physics limits there"
    )
    parser.add_argument("--fit", required=True, metavar="FIT.json", help="the fitted model")
    parser.add_argument("--where", required=True, metavar="WHERE.csv", help="errors over the space")
    parser.add_argument("--output", required=True, metavar="VERDICT.json", help="how it ended")
    parser.add_argument(
        "--keep-going",
        action="store_true",
        help="write into the files why the model cannot be used on the study, and exit with 0",
    )


def run(options: argparse.Namespace) -> None:
    space = options.space.replace("-", "_")
    if space not in SPACES:
        raise InputError(f"--space {options.space!r} is unknown; known are {', '.join(SPACES)}")
    config = load_config(options.config)
    model = model_named(options.model, config["models"], place=options.config)
    profile_uncertainty = scan_error_of(config, options.scan)
    simulated = SimulatedSpace(config, centred=space == "two_factor")
    try:
        check_columns(model, simulated.pool.factors)
    except InputError as error:
        if not options.keep_going:
            raise
        _leave_out(options, {"model": model.name, "space": space, "refused": str(error)})
        return
    found = refined_model(
        model, simulated, space=space, profile_uncertainty=profile_uncertainty, report=_print_round
    )
    print(f"{found.outcome.verdict}: {found.outcome.reason}")
    for name in TABLES:
        write_table(getattr(found, name), getattr(options, name))
    fit = with_validation(
        found.fit, config, sample=options.sample, sample_limits=options.sample_limits
    )
    write_json(fit, options.fit)
    write_json(found.verdict, options.output)


def _leave_out(options: argparse.Namespace, verdict: dict[str, str]) -> None:
    """Files that say why there is nothing in them."""
    for name, columns in TABLES.items():
        write_table(pd.DataFrame(columns=list(columns)), getattr(options, name))
    write_json(verdict, options.fit)
    write_json(verdict, options.output)
    print(verdict["refused"])


def _print_round(done: Round) -> None:
    print(
        f"round {done.number}: {done.simulations} simulations, global error {done.global_error:.2g}"
        f" ({done.global_lower:.2g} … {done.global_upper:.2g}), worst {done.worst_error:.2g}, "
        f"floor {done.floor:.2g}"
    )
