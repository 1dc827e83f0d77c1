"""Solver settings of a command: those of the study, or of the command line if given."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from squeezefilm.config.film import FilmSections
from squeezefilm.errors import InputError
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.kernel_cache import build_lock
from squeezefilm.reynolds.solver import METHODS, solve
from squeezefilm.solution import Solutions, validated_output_names

TOLERANCE_RANGE = (1e-10, 0.1)


@dataclass(frozen=True)
class SolverSettings:
    """``outputs`` are quantities beside the mean force (quantities/outputs.py)."""

    tolerance: float
    model_tolerance: float
    method: str
    device: Device
    outputs: tuple[str, ...]

    @property
    def solve_arguments(self) -> dict[str, Any]:
        """Keyword arguments of ``solve``."""
        return {"tolerance": self.tolerance, "method": self.method, "device": self.device}

    def with_auto_terms_decided(self, scenes: Scenes | Sequence[Scene]) -> Scenes | Sequence[Scene]:
        """The scenes with what of their gas is ``auto`` decided."""
        how: dict[str, Any] = {"model_tolerance": self.model_tolerance, "method": self.method}
        return resolve_auto_terms(scenes, **how, device=self.device)

    def solve(self, scenes: Scenes | Sequence[Scene]) -> Solutions:
        """Solutions of scenes, whose ``auto`` terms are decided, without further quantities."""
        return solve(self.with_auto_terms_decided(scenes), **self.solve_arguments)

    @property
    def levitation_arguments(self) -> dict[str, Any]:
        """Keyword arguments of ``levitate``."""
        return self.solve_arguments | {"model_tolerance": self.model_tolerance}


def device_of_config(config: FilmSections, *, option: str | None = None) -> Device:
    """The device that an option or the study asks for, examined by one job of a node at a time.

    Raises InputError as choose_device does.
    """
    with build_lock():
        return choose_device(config.solver.device, option=option)


def solver_settings(
    config: FilmSections,
    *,
    tolerance: float | None = None,
    method: str | None = None,
    outputs: Sequence[str] | None = None,
    device: str | None = None,
) -> SolverSettings:
    """The tolerance, method, outputs and device: those given, or else the configuration's.

    Raises InputError for a tolerance that no method is made for, an unknown method or output, and
    as ``device_of_config`` does.
    """
    tolerance = config.solver.tolerance if tolerance is None else tolerance
    method = method or config.solver.method
    if not TOLERANCE_RANGE[0] <= tolerance <= TOLERANCE_RANGE[1]:
        raise InputError(
            f"tolerance {tolerance:g} must lie between {TOLERANCE_RANGE[0]:g} and "
            f"{TOLERANCE_RANGE[1]:g}"
        )
    if method not in METHODS:
        raise InputError(f"method {method!r} is none of {', '.join(METHODS)}")
    return SolverSettings(
        tolerance=tolerance,
        model_tolerance=config.solver.model_tolerance,
        method=method,
        device=device_of_config(config, option=device),
        outputs=validated_output_names(config.outputs if outputs is None else outputs),
    )
