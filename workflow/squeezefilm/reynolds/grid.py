"""A scene's grid in space and time, and what the kernels read of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from squeezefilm.reynolds.spectral import Axis, Period, axis, period

# Nodes across the finger beyond which none is tried: there rounding begins to show at 1e-6, and a
# scene takes minutes.
MOST_SPACE = 320


@dataclass(frozen=True)
class Grid:
    """Collocation points per direction, and which directions are folded by symmetry.

    ``nx`` and ``ny`` count unknowns: a folded axis has half as many as it has nodes.
    """

    nx: int
    ny: int
    nt: int
    fold_x: bool
    fold_y: bool

    @property
    def x(self) -> Axis:
        return axis(self.nx, self.fold_x)

    @property
    def y(self) -> Axis:
        return axis(self.ny, self.fold_y)

    @property
    def t(self) -> Period:
        return period(self.nt)

    @property
    def positions(self) -> tuple[np.ndarray, np.ndarray]:
        """All nodes x, y across the finger, ends and mirror images included."""
        return _positions(self.x, self.y)

    @property
    def shape(self) -> tuple[int, int, int]:
        return self.nx, self.ny, self.nt

    @property
    def count(self) -> int:
        """Number of unknowns."""
        return self.nx * self.ny * self.nt

    def sees(self, nodes_x: int, nodes_y: int) -> bool:
        """Whether it has so many nodes across the finger along x and y."""
        return self.x.full_points >= nodes_x and self.y.full_points >= nodes_y

    def finer_than(self, other: Grid) -> bool:
        """In every direction: only then does the difference between two grids show every error."""
        return all(mine > its for mine, its in zip(self.shape, other.shape, strict=True))


@lru_cache(maxsize=256)
def _positions(x: Axis, y: Axis) -> tuple[np.ndarray, np.ndarray]:
    along_x, along_y = np.meshgrid(x.all_nodes, y.all_nodes, indexing="ij")
    return along_x, along_y


@lru_cache(maxsize=256)
def grid_matrices(grid: Grid, *, aspect: float, bearing: bool) -> np.ndarray:
    """The batch's matrices in one array, in the order in which make_grid reads them."""
    values_x, vectors_x, inverse_x = grid.x.modes
    values_y, vectors_y, inverse_y = grid.y.modes
    parts = [
        grid.x.second_derivative,
        vectors_x,
        inverse_x,
        grid.y.second_derivative / aspect**2,
        vectors_y,
        inverse_y,
        grid.t.fourier,
        grid.t.fourier.T,
        grid.t.derivative.T,
        np.add.outer(values_x, values_y / aspect**2),
        values_y / aspect**2,
        np.outer(grid.x.weights, grid.y.weights),
        np.tile(np.arange(grid.nt // 2), 2),
        np.sin(grid.t.nodes),
        np.cos(grid.t.nodes),
    ]
    if bearing:
        parts.append(grid.x.first_derivative)
    return _joined(parts)


@lru_cache(maxsize=256)
def carrying_matrices(coarse: Grid, fine: Grid) -> np.ndarray:
    """What interpolates a state to a finer grid, in the order in which ``carry`` reads it."""
    return _joined(
        [
            coarse.t.interpolation_to(fine.t).T,
            coarse.x.interpolation_to(fine.x),
            coarse.y.interpolation_to(fine.y),
        ]
    )


def _joined(parts: Iterable[np.ndarray]) -> np.ndarray:
    return np.concatenate([np.ascontiguousarray(part).ravel() for part in parts])
