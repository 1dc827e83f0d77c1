"""Terms of the equation that a study leaves to be decided for each scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.effects.budget import Budget, budgets
from squeezefilm.reynolds.modes.galerkin import wants_modes
from squeezefilm.reynolds.terms.inertia import Inertia

MODEL_TOLERANCE = 1e-3
# An effect of this share of the tolerance is included too: its first order is good to a few per
# cent of itself where it is small.
NEARLY = 0.8


def decided(
    scenes: Sequence[Scene],
    *,
    model_tolerance: float = MODEL_TOLERANCE,
    method: str = "auto",
    device: Device | None = None,
) -> list[Scene]:
    """The scenes with inertia ``included`` or ``none`` in the place of ``auto``.

    It is included where it changes the force by more than the tolerance, relative, or by what is
    not known; and left out where the method or the scene's other terms do not allow it, which the
    scene's budget shows.
    """
    open_ = [k for k, scene in enumerate(scenes) if scene.gas.inertia == "auto"]
    found = list(scenes)
    for k in open_:
        found[k] = _with_inertia(scenes[k], "none")
    allowed = [k for k in open_ if _allowed(_with_inertia(scenes[k], "included"), method)]
    for k, budget in zip(allowed, budgets([found[k] for k in allowed], device=device), strict=True):
        if _matters(budget, model_tolerance):
            found[k] = _with_inertia(scenes[k], "included")
    return found


def _with_inertia(scene: Scene, choice: str) -> Scene:
    return replace(scene, gas=replace(scene.gas, inertia=choice))


def _allowed(scene: Scene, method: str) -> bool:
    """Whether a scene with inertia is solved by the method."""
    term = Inertia()
    if wants_modes(scene):
        return not term.refused_in_modes(scene)
    if method == "march":
        return not term.refused_by_march(scene)
    if method not in ("auto", "periodic"):
        return term.knows_limit(method)
    return not term.refused_on_grid(scene)


def _matters(budget: Budget, model_tolerance: float) -> bool:
    if budget.status != "ok":
        return True
    effect = budget.inertia
    reach = abs(effect.percent) + effect.missed_percent
    return not reach < 100 * NEARLY * model_tolerance
