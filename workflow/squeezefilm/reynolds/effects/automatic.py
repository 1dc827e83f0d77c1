"""Terms of the equation that a study leaves to be decided for each scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.effects.budget import Budget, budgets
from squeezefilm.reynolds.terms import first_reason, terms_of
from squeezefilm.reynolds.terms.heat import Heat
from squeezefilm.reynolds.terms.inertia import Inertia
from squeezefilm.reynolds.terms.term import Term

MODEL_TOLERANCE = 1e-3
# An effect of this share of the tolerance is included too: its first order is good to a few per
# cent of itself where it is small.
NEARLY = 0.8
# The terms, by their names as of a gas and in a budget, in the order in which they are decided.
OPEN: dict[str, Term] = {"inertia": Inertia(), "heat": Heat()}


def decided(
    scenes: Sequence[Scene],
    *,
    model_tolerance: float = MODEL_TOLERANCE,
    method: str = "auto",
    device: Device | None = None,
) -> list[Scene]:
    """The scenes with each term of OPEN ``included`` or ``none`` in the place of ``auto``.

    It is included where it changes the force by more than the tolerance, relative, or by what is
    not known, or not by a first order; and left out where the method or the scene's other terms do
    not allow it, which the scene's budget shows.
    """
    open_ = [
        [
            name
            for name, term in OPEN.items()
            if _choice(scene, name) == "auto" and not _refused(scene, name, term, method)
        ]
        for scene in scenes
    ]
    found = [_closed(scene) for scene in scenes]
    asked = [k for k, names in enumerate(open_) if names]
    for k, budget in zip(asked, budgets([found[k] for k in asked], device=device), strict=True):
        for name in open_[k]:
            if _matters(budget, name, model_tolerance):
                found[k] = with_term(found[k], name, "included")
    return found


def kept_out(scene: Scene, *, method: str = "auto") -> list[str]:
    """What of a scene is ``auto`` and left out whatever its size, with the reason, in words."""
    return [
        f"gas.{name} is auto and left out: {reason}"
        for name, term in OPEN.items()
        if _choice(scene, name) == "auto" and (reason := _refused(scene, name, term, method))
    ]


def _choice(scene: Scene, name: str) -> str:
    return str(getattr(scene.gas, name))


def with_term(scene: Scene, name: str, choice: str) -> Scene:
    """The scene with a term of OPEN ``included``, ``none`` or ``auto``."""
    choices: dict[str, Any] = {name: choice}
    return replace(scene, gas=replace(scene.gas, **choices))


def _closed(scene: Scene) -> Scene:
    """The scene without what is to be decided."""
    for name in OPEN:
        if _choice(scene, name) == "auto":
            scene = with_term(scene, name, "none")
    return scene


def _refused(scene: Scene, name: str, term: Term, method: str) -> str:
    """Why a scene that had a term would not be solved by the method; empty where it would."""
    scene = with_term(_closed(scene), name, "included")
    if method == "composite":
        derived = term.expansion_numbers(scene) is not None
        return "" if derived else "the composite expansion is not derived with it"
    return first_reason(each.refused_on_grid(scene) for each in terms_of(scene))


def _matters(budget: Budget, name: str, model_tolerance: float) -> bool:
    if budget.status != "ok":
        return True
    effect = budget.effects[name]
    reach = abs(effect.percent) + effect.missed_percent
    return not (effect.usable and reach < 100 * NEARLY * model_tolerance)
