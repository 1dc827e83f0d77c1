"""Put a finished study on one page: what was simulated, how accurate, where it differs.

  squeezefilm summary RESULTS --config C.yaml --forces screen … --fits screen … \\
      --validations screen_on_screen … --output SUMMARY.md

RESULTS is the study's folder; the plans, fits and validations are named as the files in it are.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from reporting.pages.summary import to_markdown
from squeezefilm.io.errors import InputError
from squeezefilm.io.markdown import write_markdown
from squeezefilm.studies.config import load_config

SECTIONS = ("gas", "actuator", "finger", "solver")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="the study's results")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--forces", nargs="+", required=True, metavar="PLAN")
    parser.add_argument("--fits", nargs="+", required=True, metavar="FIT")
    parser.add_argument("--validations", nargs="+", required=True, metavar="FIT_on_PLAN")
    parser.add_argument("--output", required=True, metavar="SUMMARY.md")


def run(options: argparse.Namespace) -> None:
    results: Path = options.results
    text = to_markdown(
        study=results.resolve().name,
        settings=load_config(options.config).only(SECTIONS),
        forces={plan: results / "simulations" / plan / "forces.csv" for plan in options.forces},
        fits={fit: results / "fits" / f"{fit}.json" for fit in options.fits},
        validations={
            _pair(name): results / "validation" / f"{name}.json" for name in options.validations
        },
        claims=results / "claims.csv",
        device=results / "simulations" / "device.json",
    )
    write_markdown(text, options.output)


def _pair(name: str) -> tuple[str, str]:
    fit, on, plan = name.partition("_on_")
    if not on:
        raise InputError(f"--validations: {name!r} is not FIT_on_PLAN")
    return fit, plan
