"""The numbers and profiles of scenes of like terms, in the dimensionless form of the kernels."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import chain
from typing import Any

import numpy as np

from squeezefilm.film.scene import PadPositions, Scenes
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.layout import PackedArrays, pack_arrays
from squeezefilm.reynolds.spectral import AngleAxis, Axis
from squeezefilm.reynolds.terms import Terms, distinct_term_sets, equation_numbers

# Numbers of what is kept of the profile at some positions, where it is asked for again for many
# gaps and amplitudes; more are found anew.
MAX_CACHED_VALUES = 100_000


def gap_components(scenes: Scenes, grid: Grid) -> np.ndarray:
    """The parts of each scene's gap, (n, parts, nodes along x, nodes along y).

    Of the gap 1 + ε s sin T the profile s, or of any gap (terms/gap.py) s₁, s₂ and by how many
    metres the gap at rest is wider than h0, on all nodes of the grid's axes, ends and mirror images
    included.
    """
    parts, which = scenes.evaluate_at_positions(
        lambda places: _gap_components_at_positions(places, grid)
    )
    return np.concatenate(parts)[which]


def common_terms(scenes: Scenes) -> Terms:
    """The terms that scenes have, all of them the same.

    Raises:
        ValueError: for scenes of unlike terms.
    """
    terms, _ = distinct_term_sets(scenes)
    if len(terms) != 1:
        raise ValueError("a batch is of scenes with like terms")
    return terms[0]


def equation_numbers_table(scenes: Scenes, terms: Terms) -> np.ndarray:
    """The numbers of the scenes' equation under their names, a row for each."""
    numbers = dict(sorted(equation_numbers(scenes, terms).items()))
    widths = (len(value) if isinstance(value, tuple) else 0 for value in numbers.values())
    kind = _numbers_row_type(tuple(zip(numbers, widths, strict=True)))
    each = [value if isinstance(value, tuple) else (value,) for value in numbers.values()]
    table = np.empty((len(scenes), kind.itemsize // 8))
    for column, values in enumerate(chain.from_iterable(each)):
        table[:, column] = values
    return table.view(kind)[:, 0]


@lru_cache(maxsize=64)
def _numbers_row_type(widths: tuple[tuple[str, int], ...]) -> np.dtype[Any]:
    """Row type of the numbers: a scalar for width 0, an array of the width otherwise."""
    return np.dtype([(name, np.float64, (width,) if width else ()) for name, width in widths])


def _gap_components_at_positions(places: PadPositions, grid: Grid) -> np.ndarray:
    """The gap's parts at each position, as of ``gap_components``."""
    x, y = grid.node_positions
    values, gap = places.component_amplitudes(x, y), places.pad_profile.pad.gap
    if not gap.flat or len(values) == 2:
        second = values[1] if len(values) == 2 else np.zeros_like(values[0])
        values = np.stack([values[0], second, np.broadcast_to(gap.rise_m(x, y), second.shape)])
    nodes = len(grid.x.all_nodes), len(grid.y.all_nodes)
    return values.swapaxes(0, 1).reshape(len(places.x_m), len(values), *nodes)


def packed_profiles(
    scenes: Scenes, grids: Sequence[Grid], terms: Terms
) -> tuple[PackedArrays, np.ndarray, np.ndarray]:
    """The profile under the pad as kernels read it, once for each position.

    Returns:
        The fields at each position on each grid; which of the positions each scene has, (n,); the
        gap's parts averaged over the pad, of each scene, (n, parts).
    """
    in_space = tuple([grid.space_grid for grid in grids])

    def find_packed_profiles(places: PadPositions) -> tuple[PackedArrays, np.ndarray]:
        if len(places.x_m) * grids[-1].nx * grids[-1].ny * 8 > MAX_CACHED_VALUES:
            return _packed_profiles_at_positions(places, in_space, terms)
        return places.compute_cached(_packed_profiles_at_positions, in_space, terms)

    found, which = scenes.evaluate_at_positions(find_packed_profiles)
    fields = PackedArrays.join_rows([each for each, _ in found])
    return fields, which, np.concatenate([means for _, means in found])[which]


def _packed_profiles_at_positions(
    places: PadPositions, grids: tuple[Grid, ...], terms: Terms
) -> tuple[PackedArrays, np.ndarray]:
    parts, pad = (
        [_gap_components_at_positions(places, grid) for grid in grids],
        places.pad_profile.pad,
    )
    aspect = pad.length_y_m / pad.length_x_m
    on_grids = zip(parts, grids, strict=True)
    fields = [profile_fields(each, grid, terms=terms, aspect=aspect) for each, grid in on_grids]
    return pack_arrays(fields), mean_gap_components(parts[-1], grids[-1])


def profile_fields(
    parts: np.ndarray, grid: Grid, *, terms: Terms, aspect: float
) -> dict[str, np.ndarray]:
    """The gap's parts, their gradients and Laplacians, and what terms need, where unknowns lie.

    Each of shape (places, parts, nx, ny). Derivatives are those of the interpolating polynomial,
    lengths in units of the pad's x side.
    """
    inner_x, inner_y = grid.x.inner_slice, grid.y.inner_slice
    length_x, length_y = grid.axis_lengths(aspect)
    along_x = _slope_and_second_derivative(grid.x, length_x) @ parts[..., inner_y]
    along_y = parts[..., inner_x, :] @ _slope_and_second_derivative(grid.y, length_y).T
    slope_x, second_x = np.split(along_x, 2, axis=-2)
    slope_y, second_y = np.split(along_y, 2, axis=-1)
    fields = {
        "amplitude": parts[..., inner_x, inner_y],
        "slope_x": slope_x,
        "slope_y": slope_y,
        "laplacian": second_x + second_y,
    }
    for term in terms:
        fields.update(term.profile_fields(parts, grid))
    return fields


@lru_cache(maxsize=256)
def _slope_and_second_derivative(axis: Axis | AngleAxis, length: float) -> np.ndarray:
    """First and second derivatives where unknowns lie, below each other, from all nodes."""
    slope = axis.derivative_matrix / length
    second = axis.divergence_matrix @ slope / length
    return np.concatenate([slope[axis.inner_slice], second[axis.inner_slice]])


def mean_gap_components(parts: np.ndarray, grid: Grid) -> np.ndarray:
    """The gap's parts averaged over the pad, shape (places, parts).

    The rule neglects the ends; what it gives them is small, and the mean is no result.
    """
    weights = np.outer(grid.x.quadrature_weights, grid.y.quadrature_weights) * grid.area_density
    inner = parts[..., grid.x.inner_slice, grid.y.inner_slice]
    return np.asarray(np.tensordot(inner, weights / weights.sum(), axes=2))


def mean_gap_motion(numbers: np.ndarray, means: np.ndarray) -> np.ndarray:
    """Return the motion of the mean gap over its value at rest, (2, n).

    The factors of sin T and of cos T.

    Args:
        means: of each scene's parts of the gap, (n, parts).
    """
    epsilon = numbers["epsilon"]
    if means.shape[1] == 1:
        return np.array([means[:, 0] * epsilon, 0 * epsilon])
    first, second, rise_m = means.T
    return np.asarray(epsilon / (1 + numbers["per_rise"] * rise_m) * [first, second])
