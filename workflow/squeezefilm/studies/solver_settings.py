"""How a command solves: the study's solver section, unless the command line says otherwise."""

from __future__ import annotations

import argparse
from dataclasses import dataclass

from squeezefilm.io.errors import InputError
from squeezefilm.reynolds.solver import METHODS
from squeezefilm.studies.config import Config

TOLERANCES = (1e-10, 0.1)


@dataclass(frozen=True)
class SolverSettings:
    tolerance: float
    model_tolerance: float
    method: str


def add_solver_arguments(parser: argparse.ArgumentParser) -> None:
    """The options that go before the configuration's solver section."""
    parser.add_argument("--tolerance", type=float, help="instead of the config's solver.tolerance")
    parser.add_argument("--method", choices=METHODS, help="instead of the config's solver.method")


def solver_settings(options: argparse.Namespace, config: Config) -> SolverSettings:
    """What the options and the configuration ask for together.

    Raises:
        InputError: for a tolerance that no method is made for.
    """
    tolerance = config["solver"]["tolerance"] if options.tolerance is None else options.tolerance
    if not TOLERANCES[0] <= tolerance <= TOLERANCES[1]:
        raise InputError(
            f"tolerance {tolerance:g} must lie between {TOLERANCES[0]:g} and {TOLERANCES[1]:g}"
        )
    return SolverSettings(
        tolerance=tolerance,
        model_tolerance=config["solver"]["model_tolerance"],
        method=options.method or config["solver"]["method"],
    )
