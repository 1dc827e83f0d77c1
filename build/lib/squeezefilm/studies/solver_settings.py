"""How a command solves: the study's solver section, unless the command line says otherwise."""

import argparse
from dataclasses import dataclass

from squeezefilm.io import job
from squeezefilm.io.errors import InputError
from squeezefilm.reynolds.device import Device, choose_device, describe
from squeezefilm.reynolds.solver import METHODS
from squeezefilm.studies.config import Config

TOLERANCES = (1e-10, 0.1)


@dataclass(frozen=True)
class SolverSettings:
    tolerance: float
    model_tolerance: float
    method: str


def device_of(config: Config, *, option: str | None = None) -> Device:
    """The device that an option or the study asks for; this job's record names it.

    Raises InputError as choose_device does.
    """
    device = choose_device(config["solver"]["device"], option=option)
    job.note(device=describe(device))
    return device


def add_solver_arguments(parser: argparse.ArgumentParser) -> None:
    """The options that go before the configuration's solver section."""
    parser.add_argument("--tolerance", type=float, help="instead of the config's solver.tolerance")
    parser.add_argument("--method", choices=METHODS, help="instead of the config's solver.method")


def solver_settings(
    config: Config, *, tolerance: float | None = None, method: str | None = None
) -> SolverSettings:
    """The tolerance and the method: those given, or else the configuration's.

    Raises InputError for a tolerance that no method is made for, or an unknown method.
    """
    tolerance = config["solver"]["tolerance"] if tolerance is None else tolerance
    method = method or config["solver"]["method"]
    if not TOLERANCES[0] <= tolerance <= TOLERANCES[1]:
        raise InputError(
            f"tolerance {tolerance:g} must lie between {TOLERANCES[0]:g} and {TOLERANCES[1]:g}"
        )
    if method not in METHODS:
        raise InputError(f"method {method!r} is none of {', '.join(METHODS)}")
    return SolverSettings(
        tolerance=tolerance, model_tolerance=config["solver"]["model_tolerance"], method=method
    )
