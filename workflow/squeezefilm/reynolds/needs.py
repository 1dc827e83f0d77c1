"""What a scene needs of the full problem, and what can be left out of it without any error."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from squeezefilm.film.finger import Finger
from squeezefilm.film.outline import Outline
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.reynolds.profile_sampling import SampledProfiles, sampled_profiles
from squeezefilm.reynolds.terms import LeftOut, Terms, left_out_of, terms_of_each

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
    profile: ProfileAt
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


@dataclass(frozen=True)
class Probe:
    missed: float
    curvature_x: float
    curvature_y: float
    tail_x: np.ndarray
    tail_y: np.ndarray

    def nodes(self, share: float) -> tuple[int, int]:
        """Nodes along x and y that miss no more than a share."""
        return int(np.argmax(self.tail_x <= share)), int(np.argmax(self.tail_y <= share))


@dataclass(frozen=True)
class ProfileAt:
    """The profile under a pad at one position."""

    sampled: SampledProfiles
    position: int

    @property
    def finger(self) -> Finger:
        return self.sampled.places.pad.finger

    @property
    def uniform(self) -> bool:
        return bool(self.sampled.uniform[self.position])

    @property
    def feature_m(self) -> float:
        return self.sampled.feature_m(self.position)

    def probe(self, share: float) -> Probe:
        samples = self.sampled.at(share)
        return Probe(
            float(samples.missed[self.position]),
            *samples.curvature[self.position].tolist(),
            *samples.tail[self.position],
        )


def needs_of(scene: Scene) -> Needs:
    """What the scene needs, found from its profile, motion and gas."""
    return needs_of_each(Scenes.of([scene]))[0]


def needs_of_each(scenes: Scenes) -> list[Needs]:
    terms, which_terms = terms_of_each(scenes)
    found: dict[int, Needs] = {}
    for _, rows, some in scenes.of_each_film():
        places, which = some.places
        sampled = sampled_profiles(places)
        for row, at in zip(np.arange(len(scenes))[rows].tolist(), which.tolist(), strict=True):
            found[row] = _needs(sampled, at, terms[which_terms[row]])
    return [found[row] for row in range(len(scenes))]


@lru_cache(maxsize=4096)
def _needs(sampled: SampledProfiles, at: int, terms: Terms) -> Needs:
    gap, outline = sampled.places.pad.finger.gap, sampled.places.pad.finger.smooth_outline
    broken = {axis for term in terms for axis in term.BREAKS}
    return Needs(
        fold_x=bool(sampled.even_x[at])
        and "x" not in broken
        and gap.tilt_x_m == 0
        and (outline is None or outline.even_x),
        fold_y=bool(sampled.even_y[at])
        and "y" not in broken
        and gap.tilt_y_m == 0
        and (outline is None or outline.even_y),
        terms=terms,
        profile=ProfileAt(sampled, at),
        outline=outline,
    )
