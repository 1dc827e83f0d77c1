"""From scenes to forces with errors, each by the method that it needs."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.refinement import solve_periodic
from squeezefilm.reynolds.solution import Solution
from squeezefilm.scene import Scene


def solve(
    scenes: Sequence[Scene],
    *,
    tolerance: float,
    device: Device | None = None,
    report: Callable[[int], object] = lambda solved: None,
) -> list[Solution]:
    """Mean forces of scenes: |error| ≤ tolerance · |force| + round-off floor, or a reason why not.

    Each scene is solved by itself: its result does not depend on the others.

    Args:
        tolerance: relative error asked for.
        device: an OpenCL device; the default one if left out.
        report: called with the number of scenes that were finished, as they are.
    """
    device = device or choose_device()
    needs = [needs_of(scene) for scene in scenes]
    return solve_periodic(scenes, needs, tolerance=tolerance, device=device, report=report)
