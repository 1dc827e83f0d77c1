"""Terms of the equation, part of the pad and samples of the profile that scenes need."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from squeezefilm.film.outline import DISC_COORDINATES
from squeezefilm.film.scene import (
    MAX_CACHED_POSITIONS,
    Film,
    Rows,
    Scene,
    Scenes,
    call_cached,
    equal_row_groups,
)
from squeezefilm.reynolds.profile_sampling import (
    ProfileResolution,
    SampledProfiles,
    join_profile_resolutions,
)
from squeezefilm.reynolds.terms import Terms, absent_terms, distinct_term_sets, is_radial

DOMAIN_NAMES = np.array(["whole", "half in y", "half in x", "quarter", "radius"], dtype=object)
"""Parts of the pad that are solved: the film is even about neither axis' middle, y's, x's, both; or
it has no angle."""
ResultT = TypeVar("ResultT")


@dataclass(frozen=True, eq=False)
class SolvePlan:
    """Terms, domain and profile of scenes, each a column of shape (n,).

    Attributes:
        term_sets: the terms that scenes have beside squeezing; ``term_set_index`` is each scene's.
        fold_x, fold_y: the film is even about the pad's middle along x, y: half is enough.
        domain: the part of the pad that is solved, of DOMAIN_NAMES.
        absent_terms: names of the terms that the equation does not have, joined by ``; ``.
        sampled_profiles_by_film: of each film: which scenes have it, the profile under the pad at
            its positions, and each scene's position.
    """

    scenes: Scenes
    term_sets: Sequence[Terms]
    term_set_index: np.ndarray
    fold_x: np.ndarray
    fold_y: np.ndarray
    domain: np.ndarray
    absent_terms: np.ndarray
    sampled_profiles_by_film: Sequence[tuple[Rows, SampledProfiles, np.ndarray]]
    _cache: dict[object, Any] = field(default_factory=dict)

    @property
    def terms(self) -> Terms:
        """The terms of scenes that all have the same."""
        return self.term_sets[self.term_set_index[0]]

    def reasons_by_row(self, why: Callable[[Scene, Terms], str]) -> dict[int, str]:
        """Reasons that follow from a scene's film and terms, by row; none where they are empty."""
        found: dict[int, str] = {}
        for rows in equal_row_groups(self.scenes.film_index, self.term_set_index):
            if reason := why(
                self.scenes[int(rows[0])], self.term_sets[self.term_set_index[rows[0]]]
            ):
                found |= dict.fromkeys(rows.tolist(), reason)
        return found

    def compute_cached(self, name: str, of: Callable[..., ResultT], *arguments: Any) -> ResultT:
        """Return a value that follows from films and profiles alone, kept by position."""
        if (name, *arguments) not in self._cache:
            self._cache[name, *arguments] = of(*arguments)
        return self._cache[name, *arguments]

    def profile_resolution(self, fraction: float) -> ProfileResolution:
        """Return the samples of grids whose error is at most a fraction of the profiles, (n,)."""
        return self.compute_cached("samples", self._find_profile_resolution, fraction)

    def _find_profile_resolution(self, fraction: float) -> ProfileResolution:
        found = [
            sampled.resolution_at(fraction)[at] for _, sampled, at in self.sampled_profiles_by_film
        ]
        rows = np.concatenate([rows for rows, _, _ in self.sampled_profiles_by_film])
        return join_profile_resolutions(found)[np.argsort(rows)]


def solve_plan_of(scenes: Scenes | Sequence[Scene] | Scene) -> SolvePlan:
    """Return what scenes need by their profiles, motion and gas."""
    scenes = Scenes.of([scenes] if isinstance(scenes, Scene) else scenes)
    # The terms of a gap that is shaped at rest go by its size.
    if not scenes.is_flat or len(scenes) > MAX_CACHED_POSITIONS:
        return _build_solve_plan(scenes)
    columns = (scenes.film_index, scenes.x_m, scenes.y_m)
    plan = call_cached(
        _solve_plan_at_positions, scenes.films, *(each.tobytes() for each in columns)
    )
    return replace(plan, scenes=scenes)


def _solve_plan_at_positions(
    films: tuple[Film, ...], film_index: bytes, x_m: bytes, y_m: bytes
) -> SolvePlan:
    x, y = np.frombuffer(x_m), np.frombuffer(y_m)
    one, index = np.ones(len(x)), np.frombuffer(film_index, dtype=np.int64)
    return _build_solve_plan(Scenes(films, index, one, 0 * one, x, y, one))


def _build_solve_plan(scenes: Scenes) -> SolvePlan:
    term_sets, term_set = distinct_term_sets(scenes)
    fold_x, fold_y = np.empty((2, len(scenes)), dtype=bool)
    breaks = ["".join(term.SYMMETRY_BROKEN_AXES for term in terms) for terms in term_sets]
    profiles = []
    radial = np.array([is_radial(terms) for terms in term_sets])[term_set]
    for film, rows, some in scenes.split_by_film():
        gap, outline = film.pad.gap, film.pad.smooth_outline
        for part in equal_row_groups(radial[rows]):
            own, (places, at) = np.arange(len(scenes))[rows][part], some[part].pad_positions
            has_no_angle = bool(radial[own[0]])
            coordinates = DISC_COORDINATES if has_no_angle else outline
            sampled = places.compute_cached(SampledProfiles, coordinates)
            even_x = gap.tilt_x_m == 0 and (not outline or outline.even_x)
            even_y = gap.tilt_y_m == 0 and (not outline or outline.even_y)
            fold_x[own] = has_no_angle | sampled.even_x[at] & even_x
            fold_y[own] = has_no_angle | sampled.even_y[at] & even_y
            profiles.append((own, sampled, at))
    fold_x &= np.array(["x" not in axes for axes in breaks])[term_set]
    fold_y &= np.array(["y" not in axes for axes in breaks])[term_set]
    domain = DOMAIN_NAMES[np.where(radial, 4, 2 * fold_x + fold_y)]
    names = ["; ".join(each.name for each in absent_terms(terms)) for terms in term_sets]
    absent = np.array(names, dtype=object)[term_set]
    return SolvePlan(scenes, term_sets, term_set, fold_x, fold_y, domain, absent, profiles)
