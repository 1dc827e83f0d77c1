"""What a scene needs of the full problem, and what can be left out of it without any error."""

from __future__ import annotations

from dataclasses import dataclass

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.under_finger import UnderFinger, under_finger


@dataclass(frozen=True)
class Needs:
    """The domain and the terms that a scene needs.

    Attributes:
        fold_x, fold_y: the film is even about the finger's middle along x, y: half is enough.
        bearing: the finger slides.
        flow_terms: 1 for viscous flow, more for a rarefied gas.
        polytropic: the gas is not isothermal.
        profile: the profile under the finger.
    """

    fold_x: bool
    fold_y: bool
    bearing: bool
    flow_terms: int
    polytropic: bool
    profile: UnderFinger

    @property
    def uniform(self) -> bool:
        """Whether the whole finger sees the full amplitude."""
        return self.profile.uniform

    @property
    def halves_left_out(self) -> tuple[LeftOut, ...]:
        """Mirror images of what is solved."""
        why = "the profile is even about the finger's middle, and nothing else breaks that"
        folds = (("mirror half in x", self.fold_x), ("mirror half in y", self.fold_y))
        return tuple(LeftOut(what, why) for what, fold in folds if fold)

    @property
    def terms_left_out(self) -> tuple[LeftOut, ...]:
        """Terms of the full equation that are zero for this scene."""
        parts = (
            (not self.bearing, "bearing term", "the finger is at rest"),
            (self.flow_terms == 1, "rarefaction", "gas.rarefaction is none"),
            (not self.polytropic, "heating", "gas.polytropic_exponent is 1"),
        )
        return tuple(LeftOut(what, why) for out, what, why in parts if out)


@dataclass(frozen=True)
class LeftOut:
    """One thing that a scene does not need, and why not."""

    what: str
    why: str


def needs_of(scene: Scene) -> Needs:
    """What the scene needs, found from its profile, motion and gas.

    Sliding along x breaks the symmetry along x.
    """
    profile = under_finger(scene)
    bearing = scene.bearing_number != 0
    return Needs(
        fold_x=profile.even_x and not bearing,
        fold_y=profile.even_y,
        bearing=bearing,
        flow_terms=len(scene.flow_coefficients),
        polytropic=scene.gas.polytropic_exponent != 1,
        profile=profile,
    )
