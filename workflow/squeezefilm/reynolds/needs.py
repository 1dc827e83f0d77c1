"""What a scene needs of the full problem, and what can be left out of it without any error."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

from squeezefilm.film.outline import Outline
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.terms import LeftOut, Terms, left_out_of, terms_of
from squeezefilm.reynolds.under_finger import UnderFinger, under_finger

HALVES = tuple(
    LeftOut(what, "the profile is even about the finger's middle, and nothing else breaks that")
    for what in ("mirror half in x", "mirror half in y")
)


@dataclass(frozen=True, eq=False)
class Needs:
    """The domain and the terms that a scene needs; one for all scenes that need the same.

    Attributes:
        fold_x, fold_y: the film is even about the finger's middle along x, y: half is enough.
        terms: what the equation has beside squeezing.
        profile: the profile under the finger.
        outline: the finger's, unless it is a rectangle.
    """

    fold_x: bool
    fold_y: bool
    terms: Terms
    profile: UnderFinger
    outline: Outline | None = None

    @property
    def uniform(self) -> bool:
        """Whether the whole finger sees the full amplitude."""
        return self.profile.uniform

    @property
    def halves_left_out(self) -> tuple[LeftOut, ...]:
        """Mirror images of what is solved."""
        folds = zip(HALVES, (self.fold_x, self.fold_y), strict=True)
        return tuple(half for half, fold in folds if fold)

    @property
    def terms_left_out(self) -> tuple[LeftOut, ...]:
        """Terms of the full equation that are zero for this scene."""
        return left_out_of(self.terms)

    @cached_property
    def left_out(self) -> str:
        """Both, for a table."""
        return "; ".join(part.what for part in self.halves_left_out + self.terms_left_out)


def needs_of(scene: Scene) -> Needs:
    """What the scene needs, found from its profile, motion and gas."""
    return _needs(under_finger(scene), terms_of(scene))


@lru_cache(maxsize=4096)
def _needs(profile: UnderFinger, terms: Terms) -> Needs:
    gap, outline = profile.finger.gap, profile.finger.smooth_outline
    broken = {axis for term in terms for axis in term.BREAKS}
    return Needs(
        fold_x=profile.even_x
        and "x" not in broken
        and gap.tilt_x_m == 0
        and (outline is None or outline.even_x),
        fold_y=profile.even_y
        and "y" not in broken
        and gap.tilt_y_m == 0
        and (outline is None or outline.even_y),
        terms=terms,
        profile=profile,
        outline=outline,
    )
