"""A method's result as the record that tables and users get."""

from __future__ import annotations

from collections.abc import Iterable
from math import nan
from typing import Any

from squeezefilm.film.scene import Scene
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.needs import LeftOut


def solution_of(
    scene: Scene,
    *,
    mean: float = nan,
    error: float = nan,
    left_out: Iterable[LeftOut] = (),
    **observed: Any,
) -> Solution:
    """The record of a scene that was tried.

    Args:
        mean, error: mean overpressure over finger and period in units of p0, and its error.
        observed: what else of ``Solution``'s attributes the method knows.
    """
    return Solution(
        force_n=mean * scene.force_scale_n,
        force_error_n=error * scene.force_scale_n,
        left_out="; ".join(part.what for part in left_out),
        **observed,
    )
