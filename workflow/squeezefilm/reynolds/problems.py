"""Scenes of like terms in the dimensionless form that kernels solve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from squeezefilm.film.scene import AtPlace, Scene
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.terms import Terms, numbers_of, terms_of

# Nodes up to which the profile at a place is kept: there it is asked for many gaps and amplitudes.
MOST_KEPT = 10_000


@dataclass(frozen=True)
class Problems:
    """The scenes of a batch on one grid.

    Attributes:
        numbers: excursion ratio ``epsilon``, squeeze number ``sigma``, coefficients ``flow`` of the
            flux's terms c_k H^(3−k) ρ^(1−k) ∇P, and the terms' own numbers; one row per scene.
        terms: those that all of the scenes have.
        aspect: finger's length along y over that along x, one for the batch.
        parts: of the gap 1 + ε s sin T the profile s, or of any gap (terms/gap.py) s₁, s₂ and by
            how many metres the gap at rest is wider than h0, on all nodes of the grid's axes, ends
            and mirror images included, shape (places, parts, nodes along x, nodes along y).
        places: row of ``parts`` that each scene has.
        tolerance: relative error of the force that the iteration may leave, one for the batch.
        at: the places, where their parts are so few and simple that they are kept.
    """

    numbers: np.ndarray
    terms: Terms
    aspect: float
    parts: np.ndarray
    places: np.ndarray
    tolerance: float
    at: tuple[AtPlace, ...] = ()

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def epsilon(self) -> np.ndarray:
        return np.asarray(self.numbers["epsilon"])

    @property
    def sigma(self) -> np.ndarray:
        return np.asarray(self.numbers["sigma"])

    @property
    def narrowest(self) -> np.ndarray:
        """Least gap over h0 in a period."""
        known = "narrowest" in (self.numbers.dtype.names or ())
        return np.asarray(self.numbers["narrowest"]) if known else 1 - self.epsilon


def problems_of(scenes: Sequence[Scene], grid: Grid, *, tolerance: float) -> Problems:
    """Scenes of one finger shape and like terms on one grid."""
    return problems_on(scenes, {grid: tolerance})[0]


def problems_on(
    scenes: Sequence[Scene], tolerances: Mapping[Grid, float], *, terms: Terms | None = None
) -> list[Problems]:
    """Scenes of one finger shape and like terms on each of some grids.

    Args:
        terms: those that all of the scenes are known to have; looked for if left out.

    Raises:
        ValueError: for scenes of unlike terms.
    """
    if terms is None:
        terms = terms_of(scenes[0])
        if any(terms_of(scene) != terms for scene in scenes):
            raise ValueError("a batch is of scenes with like terms")
    numbers = _table([numbers_of(scene, terms) for scene in scenes])
    parts, places, at = _parts(scenes, list(tolerances))
    return [
        Problems(
            numbers=numbers,
            terms=terms,
            aspect=scenes[0].aspect,
            parts=each,
            places=places,
            tolerance=tolerance,
            at=at,
        )
        for each, tolerance in zip(parts, tolerances.values(), strict=True)
    ]


def _table(rows: Sequence[Any]) -> np.ndarray:
    kinds = [
        (name, np.float64, (len(value),) if isinstance(value, tuple) else ())
        for name, value in rows[0].items()
    ]
    return np.array([tuple(row.values()) for row in rows], dtype=kinds)


def _parts(
    scenes: Sequence[Scene], grids: Sequence[Grid]
) -> tuple[list[np.ndarray], np.ndarray, tuple[AtPlace, ...]]:
    """The gap's parts on all nodes of each grid at each place of the finger, each scene's place.

    And the places, where they are kept.
    """
    known: dict[AtPlace, int] = {}
    places = [known.setdefault(scene.at, len(known)) for scene in scenes]
    nodes = sum(grid.positions[0].size for grid in grids)
    ask = _profile_kept if nodes <= MOST_KEPT else _profile_on
    found = []
    at = tuple(known)
    for each in at:
        found.append(ask(each, tuple(grid.in_space for grid in grids)))
    kept = ask is _profile_kept
    parts = [np.array(on_grid) for on_grid in zip(*found, strict=True)]
    return parts, np.array(places), at if kept else ()


def _profile_on(at: AtPlace, grids: tuple[Grid, ...]) -> list[np.ndarray]:
    """The profile's parts on all nodes of each grid; asked at once, as rarely as can be."""
    x, y = (np.concatenate(each) for each in zip(*(grid.positions for grid in grids), strict=True))
    values = at.scene.parts(x, y)
    ends = np.cumsum([grid.positions[0].size for grid in grids])[:-1]
    each = zip(np.split(values, ends, axis=1), grids, strict=True)
    moving = (part.reshape(len(part), *_whole(grid)) for part, grid in each)
    return [_with_rest(at.scene, *its) for its in zip(grids, moving, strict=True)]


_profile_kept = lru_cache(maxsize=256)(_profile_on)


def _with_rest(scene: Scene, grid: Grid, moving: np.ndarray) -> np.ndarray:
    """The parts of a scene's gap, shape (parts, nodes along x, nodes along y)."""
    if scene.plain:
        return moving
    second = moving[1] if scene.actuator.profile.is_complex else np.zeros_like(moving[0])
    rise_m = scene.finger.gap.rise_m(*grid.positions).reshape(_whole(grid))
    return np.stack([moving[0], second, rise_m])


def _whole(grid: Grid) -> tuple[int, int]:
    """Nodes of a grid, ends and mirror images included."""
    return len(grid.x.all_nodes), len(grid.y.all_nodes)


def profile_fields(problems: Problems, grid: Grid) -> dict[str, np.ndarray]:
    """The gap's parts, their gradients and Laplacians, and what terms need, where unknowns lie.

    Each of shape (places, parts, nx, ny). Derivatives are those of the interpolating polynomial,
    lengths in units of the finger's x side.
    """
    parts = problems.parts
    length_x, length_y = grid.lengths(problems.aspect)
    along_x = grid.x.derivative @ parts / length_x
    along_y = parts @ grid.y.derivative.T / length_y
    everywhere = {
        "amplitude": parts,
        "slope_x": along_x,
        "slope_y": along_y,
        "laplacian": grid.x.derivative @ along_x / length_x
        + along_y @ grid.y.derivative.T / length_y,
    }
    inner = (..., grid.x.inner, grid.y.inner)
    fields = {name: values[inner] for name, values in everywhere.items()}
    for term in problems.terms:
        fields.update(term.profile_fields(parts, grid))
    return fields


def mean_parts(problems: Problems, grid: Grid) -> np.ndarray:
    """The gap's parts averaged over the finger, shape (places, parts)."""
    along_x, along_y = _averaging(grid)
    inner = problems.parts[..., grid.x.inner, grid.y.inner]
    if grid.outline:
        inner = inner * grid.density
    return np.asarray(along_x @ inner @ along_y)


def mean_motion(problems: Problems, means: Sequence[Sequence[float]]) -> list[tuple[float, float]]:
    """How each scene's gap averaged over the finger moves, over what it is at rest.

    The factors of sin T and of cos T, by the means of the gap's parts at each place.
    """
    films = zip(problems.places.tolist(), problems.epsilon.tolist(), strict=True)
    if problems.parts.shape[1] == 1:
        return [(means[place][0] * epsilon, 0.0) for place, epsilon in films]
    motions = []
    for (place, epsilon), per_rise in zip(
        films, problems.numbers["per_rise"].tolist(), strict=True
    ):
        first, second, rise = means[place]
        size = epsilon / (1 + per_rise * rise)
        motions.append((first * size, second * size))
    return motions


@lru_cache(maxsize=256)
def _averaging(grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """Weights along x and y that average what is times the density.

    The rule leaves out the ends; what it gives them is small, and the mean is no result.
    """
    everywhere = np.broadcast_to(grid.density, grid.shape[:2])
    return grid.x.weights / (grid.x.weights @ everywhere @ grid.y.weights), grid.y.weights
