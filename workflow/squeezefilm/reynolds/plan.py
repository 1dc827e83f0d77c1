"""What a scene needs: its method, decided before anything is solved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.asymptotics.scenes import Expanded, composite, not_derived_for
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic.resolution import unseen_profile
from squeezefilm.reynolds.terms import first_reason

METHODS = ("auto", "composite", "periodic")


@dataclass(frozen=True)
class Plan:
    """How a scene is treated.

    Attributes:
        method: by which its force is computed, or would be.
        expanded: the force by the composite expansion; None where the full equation is solved.
        refused: why there will be no force; empty where it is tried.
    """

    method: str
    expanded: Expanded | None = None
    refused: str = ""


PERIODIC = Plan("periodic")


def plans_of(
    scenes: Sequence[Scene], needs: Sequence[Needs], *, tolerance: float, method: str
) -> list[Plan]:
    """How ``solve`` treats each scene, as far as that is decided before solving."""
    unseen = [unseen_profile(need, tolerance=tolerance) for need in needs]
    seen = [index for index, reason in enumerate(unseen) if reason is None]
    found: dict[int, Expanded] = {}
    if method != "periodic":
        found = composite(
            [scenes[index] for index in seen],
            [needs[index] for index in seen],
            tolerance=tolerance,
            worth=method == "auto",
        )
    expanded = {seen[at]: result for at, result in found.items()}
    return [
        Plan("periodic" if method == "auto" else method, refused=reason)
        if reason
        else _plan(scene, need, expanded.get(index), method=method)
        for index, (scene, need, reason) in enumerate(zip(scenes, needs, unseen, strict=True))
    ]


def _plan(scene: Scene, needs: Needs, expanded: Expanded | None, *, method: str) -> Plan:
    if expanded is not None:
        return Plan("composite", expanded=expanded)
    if method == "composite":
        return Plan(method, refused=not_derived_for(scene, needs))
    refused = first_reason(term.refused_on_grid(scene) for term in needs.terms)
    return Plan("periodic", refused=refused) if refused else PERIODIC
