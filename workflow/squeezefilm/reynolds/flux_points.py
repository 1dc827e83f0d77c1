"""Points between the nodes of an axis, where the velocity along that axis is collocated."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from squeezefilm.reynolds.spectral import Axis, axis


@dataclass(frozen=True)
class FluxPoints:
    """Chebyshev–Gauss points of an axis, as many as it has unknowns, n.

    The pressure is known on the axis' own nodes and vanishes, as an excess, at the ends; the
    velocity along the axis is free there, so that no point of it lies at an end. About the middle
    of a folded axis the velocity along it is odd, all else even. All matrices have the shape
    (n, n) and lengths are those of the axis.
    """

    axis: Axis

    @cached_property
    def all_points(self) -> np.ndarray:
        """Shape (full_points,), on (0, 1)."""
        count = self.axis.full_points
        return (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2

    @property
    def from_all_nodes(self) -> np.ndarray:
        """Values here of a function that is known on all nodes, shape (n, nodes)."""
        return self.axis.to_points(self.all_points)[: self.axis.points]

    @property
    def from_nodes(self) -> np.ndarray:
        """Values here of a function on the nodes that vanishes at the ends."""
        return self._folded(self.axis.to_points(self.all_points)[:, 1:-1], odd=False)

    @property
    def slope(self) -> np.ndarray:
        """Derivative here of a function on the nodes that vanishes at the ends."""
        derivative = self.axis.to_points(self.all_points) @ self.axis.derivative
        return self._folded(derivative[:, 1:-1], odd=False)

    @property
    def along(self) -> np.ndarray:
        """Derivative here of the velocity along the axis."""
        return self._folded(self._derivative, odd=True)

    @property
    def to_nodes(self) -> np.ndarray:
        """The velocity along the axis on the nodes."""
        return self._folded(self._values_at(self.axis.all_nodes[1:-1]), odd=True)

    @property
    def divergence(self) -> np.ndarray:
        """Derivative on the nodes of the velocity along the axis."""
        at_nodes = self._values_at(self.axis.all_nodes[1:-1]) @ self._derivative
        return self._folded(at_nodes, odd=True)

    @property
    def across(self) -> np.ndarray:
        """Derivative on the nodes, along this axis, of a velocity along the other one.

        That velocity is taken to vanish at the ends, as it does where the gas comes in.
        """
        return self._folded(self.axis.derivative[1:-1, 1:-1], odd=False)

    @property
    def rim(self) -> np.ndarray:
        """What ``across`` lacks per velocity at each end that does not vanish, shape (2, n).

        Of a folded axis both ends are alike and their sum comes first.
        """
        first, last = self.axis.derivative[1 : self.axis.points + 1, [0, -1]].T
        return np.stack([first + last, 0 * last] if self.axis.folded else [first, last])

    @property
    def to_end(self) -> np.ndarray:
        """Factors of the values on the four nodes beside an end for the value there, shape (4,).

        As few because a polynomial through all would grow beyond bounds there.
        """
        near = self.axis.all_nodes[1:5]
        others = [np.delete(near, at) for at in range(len(near))]
        pairs = zip(near, others, strict=True)
        return np.array([np.prod(some / (some - node)) for node, some in pairs])

    def carried_to(self, finer: FluxPoints) -> np.ndarray:
        """The velocity along the axis on another one's points, shape (finer n, n)."""
        return self._folded(self._values_at(finer.all_points), odd=True, rows=finer.axis.points)

    def at(self, places: np.ndarray) -> np.ndarray:
        """The velocity along an axis that is not folded at places of it, shape (places, n)."""
        return self._values_at(places)

    @cached_property
    def _weights(self) -> np.ndarray:
        """Barycentric weights of the points (Berrut and Trefethen 2004)."""
        index = np.arange(self.axis.full_points)
        return (-1.0) ** index * np.sin(np.pi * (index + 0.5) / len(index))

    def _values_at(self, places: np.ndarray) -> np.ndarray:
        """Interpolation from all points."""
        distance = np.subtract.outer(places, self.all_points)
        hit = distance == 0
        matrix = self._weights / np.where(hit, 1.0, distance)
        matrix[hit.any(axis=1)] = 0.0
        matrix[hit] = 1.0
        return np.asarray(matrix / matrix.sum(axis=1, keepdims=True))

    @cached_property
    def _derivative(self) -> np.ndarray:
        """Derivative on all points."""
        distance = np.subtract.outer(self.all_points, self.all_points)
        np.fill_diagonal(distance, 1.0)
        matrix = np.divide.outer(1 / self._weights, 1 / self._weights) / distance
        np.fill_diagonal(matrix, 0.0)
        np.fill_diagonal(matrix, -matrix.sum(axis=1))
        return matrix

    def _folded(self, matrix: np.ndarray, *, odd: bool, rows: int | None = None) -> np.ndarray:
        """What the first half of the points says of all, by the symmetry of what it acts on."""
        if not self.axis.folded:
            return matrix
        n = self.axis.points
        half = matrix[: rows or n]
        return np.asarray(half[:, :n] + (-1 if odd else 1) * half[:, : n - 1 : -1])


@lru_cache(maxsize=64)
def flux_points(points: int, folded: bool) -> FluxPoints:
    """Those of the axis with so many unknowns; their matrices are computed once."""
    return FluxPoints(axis(points, folded))
