"""What solving a scene gives, whatever the method."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite, nan

from squeezefilm.reynolds.needs import LeftOut


@dataclass(frozen=True)
class Solution:
    """The mean force of one scene and how it was obtained.

    Attributes:
        force_n: mean force over a period; NaN unless ``status`` is ``ok``.
        force_error_n: estimate of its absolute error.
        status: ``ok``, or what went wrong.
        method: name of the method.
        left_out: what the scene did not need.
        nx, ny, nt: collocation points across the finger, or along a radius and around for an
            elliptical one, and over the period.
        newton_steps, krylov_iterations: over all grids.
        residual: estimate of the mass error that Newton's iteration left, relative to p0 h0.
        work: floating-point operations of the iterations, for sharing out run time.
    """

    force_n: float
    force_error_n: float
    status: str
    method: str
    left_out: str
    nx: int
    ny: int
    nt: int
    newton_steps: int
    krylov_iterations: int
    residual: float
    work: float


def left_out_text(parts: Iterable[LeftOut]) -> str:
    """The ``left_out`` column of a scene."""
    return "; ".join(part.what for part in parts)


def error_text(error: float, *, allowed: float, force: float) -> str:
    """An error that is too large, in the terms of the tolerance: as a share of the force."""
    if force == 0 or not isfinite(error):
        return "the error is not known"
    size = abs(force)
    return f"error {error / size:.1e} of the force, {allowed / size:.1g} allowed"


def refusal(status: str, *, method: str) -> Solution:
    """A scene that was not tried, with the reason."""
    return Solution(
        force_n=nan,
        force_error_n=nan,
        status=status,
        method=method,
        left_out="",
        nx=0,
        ny=0,
        nt=0,
        newton_steps=0,
        krylov_iterations=0,
        residual=0.0,
        work=0.0,
    )
