"""What each limit was derived for, and so what it knows of a scene."""

from __future__ import annotations

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.terms.gap import AnyGap

# Those that know a gap that is shaped at rest.
SHAPED = ("fast-limit", "boundary-layer")


def unknown_to(name: str, scene: Scene, needs: Needs) -> str:
    """Why a limit does not know a scene; empty where it does."""
    if scene.finger.shape != "rectangle":
        return f"{name} was derived for rectangular fingers"
    if scene.epsilon == 0:
        return f"{name} does not know a surface at rest"
    shaped = not scene.finger.gap.flat
    if shaped and name not in SHAPED:
        known = " and ".join(SHAPED)
        return f"{name} was derived for a gap that is even at rest; {known} know others"
    others = [term for term in needs.terms if not isinstance(term, AnyGap)]
    if shaped and others:
        labels = " and ".join(term.label for term in others)
        return f"{name} was not derived for {labels} under a gap that is shaped at rest"
    if scene.actuator.profile.is_complex and scene.gas.inertia == "included":
        return f"{name} with inertia was derived for a vibration in one phase"
    if unknown := [term.label for term in needs.terms if not term.knows_limit(name)]:
        return f"{name} does not know {' and '.join(unknown)}"
    if name == "closed-form" and not needs.uniform:
        return "closed-form is that of a piston: the profile differs from place to place"
    return ""
