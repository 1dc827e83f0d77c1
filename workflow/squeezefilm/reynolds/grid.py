"""A scene's grid in space and time, and what the kernels read of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import sqrt

import numpy as np

from squeezefilm.film.outline import DISC_COORDINATES, DiscCoordinates, Outline
from squeezefilm.film.scene import HashedOnce
from squeezefilm.reynolds.spectral import (
    AngleAxis,
    Axis,
    TimeAxis,
    cached_angle_axis,
    cached_axis,
    cached_radial_axis,
    cached_time_axis,
)
from squeezefilm.reynolds.terms import NamedArrays, Term, Terms, preconditioner_count

# Nodes across the pad beyond which none is tried: there rounding begins to show at 1e-6, and a
# scene takes minutes.
MAX_NODES_ACROSS = 320
# The force can agree between two grids by chance. The lowest moments of the mean pressure hardly
# ever all do: twice their largest change covered the finer grid's true error in 99.8 % of 414
# pairs of grids, drawn over ε 0.01–0.95 and σ 0.1–3e5. The kernel takes three.
MOMENT_COUNT = 3
# Names of the matrices that interpolate the pressure to a finer grid.
INTERPOLATION_MATRIX_NAMES = ("carry_t", "carry_x", "carry_y")


@dataclass(frozen=True)
class Grid(HashedOnce):
    """Collocation points per direction, and which directions are folded by symmetry.

    ``nx`` and ``ny`` count unknowns: a folded axis has half as many as it has nodes. Under an
    outline that is no rectangle x and y are its coordinates μ, in units of the strip's width, and
    ν (film/outline.py); the film is even about the pad's middle along x, y where ``fold_x``,
    ``fold_y`` say so. A single unknown along y is that of a film without angle: x is the disc's
    diameter, and the unknown stands for all around.
    """

    nx: int
    ny: int
    nt: int
    fold_x: bool
    fold_y: bool
    outline: Outline | None = None
    __hash__ = HashedOnce.__hash__

    @cached_property
    def x(self) -> Axis:
        if self.is_radial:
            return cached_radial_axis(self.nx)
        return cached_axis(
            self.nx,
            self.outline.symmetries_in_nu(self.fold_x, self.fold_y)[0]
            if self.outline
            else self.fold_x,
        )

    @cached_property
    def y(self) -> Axis | AngleAxis:
        if self.is_radial:
            return cached_angle_axis(self.ny, True, True)
        if self.outline is None:
            return cached_axis(self.ny, self.fold_y)
        return cached_angle_axis(self.ny, *self.outline.symmetries_in_nu(self.fold_x, self.fold_y))

    @property
    def is_radial(self) -> bool:
        """Return whether the grid is along a disc's radius alone."""
        return self.ny == 1

    @property
    def pad_coordinates(self) -> Outline | DiscCoordinates | None:
        """Return what x and y are coordinates of, unless they are those of a rectangle."""
        return DISC_COORDINATES if self.is_radial else self.outline

    @property
    def t(self) -> TimeAxis:
        return cached_time_axis(self.nt)

    @cached_property
    def node_positions(self) -> tuple[np.ndarray, np.ndarray]:
        """All nodes x, y across the pad, ends and mirror images included, row by row."""
        along_x, along_y = np.meshgrid(self.x.all_nodes, self.y.all_nodes, indexing="ij")
        flat = along_x.ravel(), along_y.ravel()
        return self.pad_coordinates.side_fractions(*flat) if self.pad_coordinates else flat

    @cached_property
    def area_density(self) -> np.ndarray | float:
        """Area of the pad that the unknowns stand for, over the mean, shape (nx, ny) or 1."""
        return self.area_ratio_at(self.x.nodes) * self.inverse_mean_area

    @property
    def inverse_mean_area(self) -> float:
        """One over the mean of ``area`` over the pad."""
        return (
            self.outline.mean_edge_jacobian / self.outline.mean_map_jacobian
            if self.outline
            else 1.0
        )

    def area_ratio_at(self, across: np.ndarray) -> np.ndarray | float:
        """Area of an outline behind places along x and the unknowns along y, over the typical.

        It weighs what changes in time (terms/outline.py); 1 under a rectangle.
        """
        if self.outline is None:
            return 1.0
        return (
            self.outline.map_jacobian(*self._mu_nu_coordinates(across))
            / self.outline.mean_edge_jacobian
        )

    def conformal_map_slope(self, across: np.ndarray) -> np.ndarray | float:
        """z′ of an outline there, by the same lengths; 1 under a rectangle."""
        if self.outline is None:
            return 1.0
        return self.outline.conformal_map_slope(*self._mu_nu_coordinates(across)) / sqrt(
            self.outline.mean_edge_jacobian
        )

    def conformal_map_log_slope(self, across: np.ndarray) -> np.ndarray | float:
        """z″/z′ of an outline there, by the same lengths; 0 under a rectangle."""
        if self.outline is None:
            return 0.0
        return self.outline.conformal_map_log_slope(*self._mu_nu_coordinates(across)) / sqrt(
            self.outline.mean_edge_jacobian
        )

    def _mu_nu_coordinates(self, across: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return μ and ν there."""
        assert self.outline
        return self.outline.edge_mu * (2 * across[:, None] - 1), self.y.nodes

    def axis_lengths(self, aspect: float) -> tuple[float, float]:
        """Return the lengths of the axes' units; the x side is 1, the y side ``aspect``.

        Under an outline they are such that the film equation has the area behind a point, over the
        typical, with its rates (terms/outline.py).
        """
        if self.outline is None:
            return 1.0, aspect
        unit = sqrt(self.outline.mean_edge_jacobian)
        return 2 * self.outline.edge_mu * unit, unit

    def nodes_per_length(self, aspect: float) -> tuple[float, float]:
        """Nodes of each axis for a unit of its length; those around lie as far apart as so few."""
        length_x, length_y = self.axis_lengths(aspect)
        sides = 4 if self.outline else 1
        return self.x.full_point_count / length_x, self.y.full_point_count / (sides * length_y)

    @property
    def space_time_shape(self) -> tuple[int, int, int]:
        return self.nx, self.ny, self.nt

    @cached_property
    def nodes_across(self) -> tuple[int, int]:
        """Nodes across the pad along x and y; one around for a film without angle."""
        return self.x.full_point_count, 1 if self.is_radial else self.y.full_point_count

    @cached_property
    def space_grid(self) -> Grid:
        """Return the grid of the same nodes across the pad that all of its kind share."""
        return replace(self, nt=4)

    @cached_property
    def unknown_count(self) -> int:
        """Number of unknowns."""
        return self.nx * self.ny * self.nt

    def has_min_nodes(self, nodes_x: float, nodes_y: float) -> bool:
        """Return whether the grid has so many nodes across the pad along x and y."""
        return self.x.full_point_count >= nodes_x and self.y.full_point_count >= nodes_y


@lru_cache(maxsize=256)
def grid_matrices(grid: Grid, *, aspect: float, terms: Terms) -> dict[str, np.ndarray]:
    """The matrices of a grid over the period, under the names that kernels know them by."""
    if terms:
        parts = dict(grid_matrices(grid, aspect=aspect, terms=()))
        for term in terms:
            parts.update(_matrices_of_term(term, grid, aspect))
        return parts
    values_x, vectors_x, inverse_x = grid.x.even_odd_modes
    values_y, vectors_y, inverse_y = grid.y.even_odd_modes
    length_x, length_y = grid.axis_lengths(aspect)
    values_x, values_y = values_x / length_x**2, values_y / length_y**2
    return {
        "laplace_x": grid.x.second_derivative_parts / length_x**2,
        "modes_x": vectors_x,
        "to_modes_x": inverse_x,
        "laplace_y": grid.y.second_derivative_parts / length_y**2,
        "modes_y": vectors_y,
        "to_modes_y": inverse_y,
        "time_derivative": grid.t.derivative_matrix.T,
        "eigenvalues": np.add.outer(values_x, values_y),
        "eigenvalues_y": values_y,
        "weights": np.outer(grid.x.quadrature_weights, grid.y.quadrature_weights)
        * grid.area_density,
        "moments_x": _cosine_moment_matrix(grid.x),
        "moments_y": _cosine_moment_matrix(grid.y),
        "sine": np.sin(grid.t.nodes),
        "cosine": np.cos(grid.t.nodes),
    }


@lru_cache(maxsize=256)
def _matrices_of_term(term: Term, grid: Grid, aspect: float) -> NamedArrays:
    return term.matrices(grid, aspect=aspect)


def _cosine_moment_matrix(axis: Axis | AngleAxis) -> np.ndarray:
    """The moments without their weights, and the first, which is 1, once more: shape (n, 4)."""
    cosines = axis.cosine_moment_matrix(MOMENT_COUNT) / axis.quadrature_weights
    return np.stack([*cosines, cosines[0]], axis=1)


@lru_cache(maxsize=256)
def interpolation_matrices(coarse: Grid, fine: Grid, *, terms: Terms) -> dict[str, np.ndarray]:
    """Return the matrices that interpolate a state to a finer grid."""
    matrices = (
        coarse.t.matrix_at(fine.t.nodes).T,
        coarse.x.matrix_at(fine.x.nodes),
        coarse.y.matrix_at(fine.y.nodes),
    )
    parts = dict(zip(INTERPOLATION_MATRIX_NAMES, matrices, strict=True))
    for term in terms:
        parts.update(term.interpolation_matrices(coarse, fine))
    return parts


@lru_cache(maxsize=4096)
def krylov_iteration_flops(grid: Grid, terms: Terms = ()) -> float:
    """Floating-point operations of one Krylov iteration's products."""
    in_space = (
        2
        + max(preconditioner_count(terms), 1)
        + sum(term.SPACE_MATRIX_PRODUCT_COUNT for term in terms)
    )
    in_time = 2 + sum(term.TIME_MATRIX_PRODUCT_COUNT for term in terms)
    # Along x and y half of a row where an axis is whole.
    row = grid.nx // (1 + grid.x.uses_even_odd_parts) + grid.ny // (1 + grid.y.uses_even_odd_parts)
    return 2.0 * grid.unknown_count * (in_space * row + in_time * grid.nt)
