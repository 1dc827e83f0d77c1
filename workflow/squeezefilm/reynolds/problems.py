"""Scenes of like terms in the dimensionless form that kernels solve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
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
        amplitude: profile s on all nodes of the grid's axes, ends and mirror images included,
            shape (places, full nx + 2, full ny + 2).
        places: row of ``amplitude`` that each scene has.
        tolerance: relative error of the force that the iteration may leave, one for the batch.
    """

    numbers: np.ndarray
    terms: Terms
    aspect: float
    amplitude: np.ndarray
    places: np.ndarray
    tolerance: float

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def epsilon(self) -> np.ndarray:
        return np.asarray(self.numbers["epsilon"])

    @property
    def sigma(self) -> np.ndarray:
        return np.asarray(self.numbers["sigma"])

    def some(self, which: np.ndarray) -> Problems:
        """Some of the scenes."""
        return replace(self, numbers=self.numbers[which], places=self.places[which])


def problems_of(scenes: Sequence[Scene], grid: Grid, *, tolerance: float) -> Problems:
    """Scenes of one finger shape and like terms on one grid."""
    return problems_on(scenes, {grid: tolerance})[0]


def problems_on(scenes: Sequence[Scene], tolerances: Mapping[Grid, float]) -> list[Problems]:
    """Scenes of one finger shape and like terms on each of some grids.

    Raises:
        ValueError: for scenes of unlike terms.
    """
    terms = terms_of(scenes[0])
    if any(terms_of(scene) != terms for scene in scenes):
        raise ValueError("a batch is of scenes with like terms")
    numbers = _table([numbers_of(scene, terms) for scene in scenes])
    amplitudes, places = _amplitudes(scenes, list(tolerances))
    return [
        Problems(
            numbers=numbers,
            terms=terms,
            aspect=scenes[0].aspect,
            amplitude=amplitude,
            places=places,
            tolerance=tolerance,
        )
        for amplitude, tolerance in zip(amplitudes, tolerances.values(), strict=True)
    ]


def _table(rows: Sequence[Any]) -> np.ndarray:
    kinds = [(name, np.float64, np.shape(value)) for name, value in rows[0].items()]
    return np.array([tuple(row.values()) for row in rows], dtype=kinds)


def _amplitudes(
    scenes: Sequence[Scene], grids: Sequence[Grid]
) -> tuple[list[np.ndarray], np.ndarray]:
    """The profile on all nodes of each grid at each place of the finger, and each scene's place."""
    known: dict[object, tuple[int, Scene]] = {}
    places = [known.setdefault(scene.place, (len(known), scene))[0] for scene in scenes]
    nodes = sum(grid.positions[0].size for grid in grids)
    ask = _profile_kept if nodes <= MOST_KEPT else _profile_on
    found = [ask(AtPlace(scene), tuple(grids)) for _, scene in known.values()]
    return [np.stack(on_grid) for on_grid in zip(*found, strict=True)], np.array(places)


def _profile_on(at: AtPlace, grids: tuple[Grid, ...]) -> list[np.ndarray]:
    """The profile on all nodes of each grid; asked at once, as rarely as can be."""
    x, y = (np.concatenate(each) for each in zip(*(grid.positions for grid in grids), strict=True))
    values, found, begin = at.scene.amplitude(x, y), [], 0
    for grid in grids:
        shape = grid.x.full_points + 2, grid.y.full_points + 2
        end = begin + shape[0] * shape[1]
        found.append(values[begin:end].reshape(shape))
        begin = end
    return found


_profile_kept = lru_cache(maxsize=256)(_profile_on)


def profile_fields(problems: Problems, grid: Grid) -> dict[str, np.ndarray]:
    """s, |∇s|², Δs and what terms need where the unknowns lie, each shape (places, nx, ny).

    Derivatives are those of the interpolating polynomial, lengths in units of the finger's x side.
    """
    s = problems.amplitude
    along_x = grid.x.derivative @ s
    along_y = s @ grid.y.derivative.T / problems.aspect
    everywhere = {
        "amplitude": s,
        "gradient_squared": along_x**2 + along_y**2,
        "laplacian": grid.x.derivative @ along_x + along_y @ grid.y.derivative.T / problems.aspect,
    }
    inner = (slice(None), slice(1, grid.nx + 1), slice(1, grid.ny + 1))
    fields = {name: values[inner] for name, values in everywhere.items()}
    for term in problems.terms:
        fields.update(term.profile_fields(s, grid))
    return fields


def mean_amplitude(problems: Problems, grid: Grid) -> np.ndarray:
    """The profile averaged over the finger, for each scene, shape (scenes,)."""
    inner = problems.amplitude[:, 1 : grid.nx + 1, 1 : grid.ny + 1]
    # The rule leaves out the ends; what it gives them is small, and the mean is no result.
    whole = grid.x.weights.sum() * grid.y.weights.sum()
    return np.asarray(grid.x.weights @ inner @ grid.y.weights / whole)[problems.places]
