"""What scenes need of the full problem, and what is not needed without any error."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np

from squeezefilm.film.scene import Film, Rows, Scene, Scenes, distinct, rows_alike
from squeezefilm.reynolds.profile_sampling import (
    SampledProfiles,
    Samples,
    joined_samples,
    sampled_profiles,
)
from squeezefilm.reynolds.terms import LeftOut, Terms, left_out_of, terms_of_each

Result = TypeVar("Result")
# Scenes whose needs are kept: those at the same places ask again for other gaps and amplitudes.
MOST_KEPT = 256
HALVES = tuple(
    LeftOut(what, "the profile is even about the finger's middle, and nothing else breaks that")
    for what in ("mirror half in x", "mirror half in y")
)


@dataclass(frozen=True, eq=False)
class Needs:
    """The domain and the terms that scenes need, each a column of shape (n,).

    Attributes:
        kinds: the terms that scenes have beside squeezing; ``kind`` is each scene's.
        fold_x, fold_y: the film is even about the finger's middle along x, y: half is enough.
        uniform: the whole finger sees the full amplitude.
        profiles: of each film: which scenes have it, the profile under the finger at its
            positions, and each scene's position.
    """

    scenes: Scenes
    kinds: Sequence[Terms]
    kind: np.ndarray
    fold_x: np.ndarray
    fold_y: np.ndarray
    uniform: np.ndarray
    profiles: Sequence[tuple[Rows, SampledProfiles, np.ndarray]]
    _known: dict[object, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.scenes)

    def __getitem__(self, rows: np.ndarray) -> Needs:
        place = np.full(len(self), -1)
        place[rows] = np.arange(len(rows))
        profiles: list[tuple[Rows, SampledProfiles, np.ndarray]] = []
        for of_film, sampled, at in self.profiles:
            found = place[of_film]
            if isinstance(of_film, slice):
                profiles.append((of_film, sampled, at[rows]))
            elif (found >= 0).any():
                profiles.append((found[found >= 0], sampled, at[found >= 0]))
        return Needs(
            scenes=self.scenes[rows],
            kinds=self.kinds,
            kind=self.kind[rows],
            fold_x=self.fold_x[rows],
            fold_y=self.fold_y[rows],
            uniform=self.uniform[rows],
            profiles=profiles,
        )

    @property
    def terms(self) -> Terms:
        """The terms that all of the scenes have.

        Raises:
            ValueError: for scenes of unlike terms.
        """
        if (self.kind != self.kind[0]).any():
            raise ValueError("these scenes have unlike terms")
        return self.kinds[self.kind[0]]

    def alike(self) -> Iterator[tuple[np.ndarray, Scene, Terms]]:
        """Scenes of one film and like terms: which they are, the first of them, the terms."""
        code = self.scenes.film_index * len(self.kinds) + self.kind
        for rows in rows_alike(code):
            yield rows, self.scenes[int(rows[0])], self.kinds[self.kind[rows[0]]]

    def once(self, name: str, of: Callable[..., Result], *arguments: Any) -> Result:
        """What follows from films and profiles alone, found once for scenes at the same places."""
        if (name, *arguments) not in self._known:
            self._known[name, *arguments] = of(*arguments)
        return self._known[name, *arguments]

    def samples(self, share: float) -> Samples:
        """What grids that miss no more than a share of the profiles resolve, (n,)."""
        return self.once("samples", self._sampled, share)

    def _sampled(self, share: float) -> Samples:
        found = [sampled.at(share)[at] for _, sampled, at in self.profiles]
        if len(found) == 1:
            return found[0]
        rows = np.concatenate([rows for rows, _, _ in self.profiles])
        return joined_samples(found)[np.argsort(rows)]

    def position(self, row: int) -> tuple[SampledProfiles, int]:
        """The profile under one scene's finger: the positions sampled, and which of them it is."""
        for rows, sampled, at in self.profiles:
            of_film = np.arange(len(self))[rows]
            if (found := np.flatnonzero(of_film == row)).size:
                return sampled, int(at[found[0]])
        raise IndexError(row)

    def simplifications(self, row: int) -> tuple[LeftOut, ...]:
        """What one scene does not need: mirror images of what is solved, terms that are zero."""
        folds = zip(HALVES, (self.fold_x[row], self.fold_y[row]), strict=True)
        return *(half for half, fold in folds if fold), *left_out_of(self.kinds[self.kind[row]])

    def left_out(self) -> list[str]:
        """The same of each scene, for a table."""
        return self.once("left out", self._left_out)

    def _left_out(self) -> list[str]:
        code = 4 * self.kind + 2 * self.fold_x + self.fold_y
        first, which = distinct(code)
        texts = ["; ".join(part.what for part in self.simplifications(row)) for row in first]
        return [texts[each] for each in which.tolist()]


def needs_of(scenes: Scenes | Sequence[Scene] | Scene) -> Needs:
    """What scenes need, from their profiles, motion and gas."""
    scenes = Scenes.of([scenes] if isinstance(scenes, Scene) else scenes)
    flat = all(film.finger.gap.flat for film in scenes.films)
    if not flat or len(scenes) > MOST_KEPT:  # a gap's terms go by its size where it is shaped
        return _needs_of(scenes)
    columns = (scenes.film_index, scenes.x_m, scenes.y_m)
    return replace(_kept(scenes.films, *(each.tobytes() for each in columns)), scenes=scenes)


@lru_cache(maxsize=64)
def _kept(films: tuple[Film, ...], film_index: bytes, x_m: bytes, y_m: bytes) -> Needs:
    x, y = np.frombuffer(x_m), np.frombuffer(y_m)
    one = np.ones(len(x))
    index = np.frombuffer(film_index, dtype=np.int64)
    return _needs_of(Scenes(films, index, one, 0 * one, x, y, one))


def _needs_of(scenes: Scenes) -> Needs:
    kinds, kind = terms_of_each(scenes)
    fold_x, fold_y, uniform = np.empty((3, len(scenes)), dtype=bool)
    broken = np.array([_broken(terms) for terms in kinds], dtype=bool)[kind]
    profiles = []
    for film, rows, some in scenes.of_each_film():
        places, at = some.places
        sampled = sampled_profiles(places)
        even_x, even_y = _even(film)
        fold_x[rows], fold_y[rows] = even_x & sampled.even_x[at], even_y & sampled.even_y[at]
        uniform[rows] = sampled.uniform[at]
        profiles.append((rows, sampled, at))
    fold_x &= ~broken[:, 0]
    fold_y &= ~broken[:, 1]
    return Needs(scenes, kinds, kind, fold_x, fold_y, uniform, profiles)


@lru_cache(maxsize=256)
def _broken(terms: Terms) -> tuple[bool, bool]:
    """Whether terms break the symmetry along x, y."""
    axes = "".join(term.BREAKS for term in terms)
    return "x" in axes, "y" in axes


def _even(film: Film) -> tuple[bool, bool]:
    """Whether a film's pad is even about its middle along x, y."""
    gap, outline = film.finger.gap, film.finger.smooth_outline
    return (
        gap.tilt_x_m == 0 and (outline is None or outline.even_x),
        gap.tilt_y_m == 0 and (outline is None or outline.even_y),
    )
