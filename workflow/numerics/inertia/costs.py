"""What a plan's budget costs beside its simulations, and these with inertia: processor time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import median

from numerics.timing import processor_seconds
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.effects.budget import budgets


@dataclass(frozen=True)
class Costs:
    """Seconds of all scenes together, each the median of repeats taken by turns.

    Attributes:
        budget: of what the equation leaves out.
        without: of their forces without inertia and heat.
        inertia: of their forces with inertia alone.
        without_alone, inertia_alone: the same, each scene asked for by itself.
    """

    scenes: int
    tolerance: float
    budget: float
    without: float
    inertia: float
    without_alone: float
    inertia_alone: float

    @property
    def row(self) -> dict[str, float]:
        """With the budget over the simulations, and inertia over none."""
        shares = {
            "budget_over_without": self.budget / self.without,
            "inertia_over_without": self.inertia / self.without,
            "inertia_over_without_alone": self.inertia_alone / self.without_alone,
        }
        return vars(self) | shares


def costs(scenes: Sequence[Scene], *, tolerance: float, repeats: int, device: Device) -> Costs:
    """All of them, one after the other in each repeat, when kernels are compiled."""

    def having(inertia: str) -> list[Scene]:
        return [
            replace(each, gas=replace(each.gas, inertia=inertia, heat="none")) for each in scenes
        ]

    def forces(some: Sequence[Scene]) -> object:
        return solve(some, tolerance=tolerance, method="periodic", device=device)

    still, heavy = having("none"), having("included")
    calls: tuple[Callable[[], object], ...] = (
        lambda: budgets(scenes, device=device),
        lambda: forces(still),
        lambda: forces(heavy),
        lambda: [forces([each]) for each in still],
        lambda: [forces([each]) for each in heavy],
    )
    for call in calls:
        call()
    seconds = [[_seconds(call) for call in calls] for _ in range(repeats)]
    return Costs(len(scenes), tolerance, *map(median, zip(*seconds, strict=True)))


def _seconds(call: Callable[[], object]) -> float:
    begin = processor_seconds()
    call()
    return processor_seconds() - begin
