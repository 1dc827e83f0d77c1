"""Grids whose nodes crowd at the finger's rim: other nodes, and another discretisation, than the
solver's, with far fewer unknowns where layers and corners ask for them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import cosh, tanh

import numpy as np

from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.spectral import Axis


@dataclass(frozen=True)
class StretchedAxis(Axis):
    """Chebyshev collocation in z, 2x − 1 = tanh(a (2z − 1))/tanh a.

    Attributes:
        stretch: a.
    """

    stretch: float = 1.0

    @cached_property
    def _plain(self) -> Axis:
        return Axis(self.points, self.folded)

    @cached_property
    def _z(self) -> np.ndarray:
        """2z − 1 on all nodes."""
        return 2 * self._plain.all_nodes - 1

    @cached_property
    def all_nodes(self) -> np.ndarray:
        return (1 + np.tanh(self.stretch * self._z) / tanh(self.stretch)) / 2

    @cached_property
    def _slope(self) -> np.ndarray:
        """dx/dz on all nodes."""
        return self.stretch / tanh(self.stretch) / np.cosh(self.stretch * self._z) ** 2

    @cached_property
    def derivative(self) -> np.ndarray:
        return self._plain.derivative / self._slope[:, None]

    @cached_property
    def second_derivative(self) -> np.ndarray:
        inner = slice(1, -1)
        plain = Axis(self.full_points, folded=False)
        bend = -4 * self.stretch * np.tanh(self.stretch * self._z[inner])
        matrix = plain.second_derivative - bend[:, None] * plain.first_derivative
        return self._fold(matrix / self._slope[inner, None] ** 2)

    @cached_property
    def weights(self) -> np.ndarray:
        return self._plain.weights * self._slope[1 : self.points + 1]

    def to_points(self, places: np.ndarray) -> np.ndarray:
        z = np.arctanh((2 * places - 1) * tanh(self.stretch)) / self.stretch
        return self._plain.to_points(np.clip((1 + z) / 2, 0.0, 1.0))


@dataclass(frozen=True)
class StretchedGrid(Grid):
    """A grid with such axes.

    Attributes:
        stretch_x, stretch_y: of each.
    """

    stretch_x: float = 1.0
    stretch_y: float = 1.0

    @property
    def x(self) -> Axis:
        return _axis(self.nx, self.fold_x, self.stretch_x)

    @property
    def y(self) -> Axis:
        return _axis(self.ny, self.fold_y, self.stretch_y)


def coarser_inside(stretch: float) -> float:
    """How much farther apart nodes are in the middle than without the stretch."""
    return stretch / tanh(stretch)


def finer_at_rim(stretch: float) -> float:
    """How much closer they are at the rim."""
    return cosh(stretch) ** 2 / coarser_inside(stretch)


@lru_cache(maxsize=64)
def _axis(points: int, folded: bool, stretch: float) -> StretchedAxis:
    return StretchedAxis(points=points, folded=folded, stretch=stretch)
