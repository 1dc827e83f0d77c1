"""What a scene needs: its method, decided before anything is solved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from squeezefilm.reynolds.asymptotics.scenes import Expanded, composite, not_derived_for
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic.resolution import unseen_profiles
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


def plans_of(needs: Needs, *, tolerance: float, method: str) -> dict[int, Plan]:
    """How ``solve`` treats scenes, as far as that is decided before solving.

    By row, of those that are not solved as PERIODIC.
    """
    unseen = unseen_profiles(needs, tolerance=tolerance)
    named = "periodic" if method == "auto" else method
    plans = {row: Plan(named, refused=reason) for row, reason in unseen.items()}
    if method != "periodic":
        seen = np.setdiff1d(np.arange(len(needs)), list(unseen))
        some = needs[seen] if unseen else needs
        found = composite(some, tolerance=tolerance, worth=method == "auto")
        rows = seen.tolist()
        plans |= {rows[at]: Plan("composite", expanded=each) for at, each in found.items()}
        if method == "composite":
            reasons = {rows[at]: reason for at, reason in not_derived_for(some).items()}
            return {row: Plan(method, refused=reason) for row, reason in reasons.items()} | plans
    for alike, scene, terms in needs.alike():
        if reason := first_reason(term.refused_on_grid(scene) for term in terms):
            plans = dict.fromkeys(alike.tolist(), Plan("periodic", refused=reason)) | plans
    return plans
