"""Equidistant collocation around a pad: the coordinate ν of its outline (film/outline.py)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from squeezefilm.reynolds.spectral import Period, period


@dataclass(frozen=True)
class Around:
    """Fourier collocation on [start, start + 2π), between the mirror axes, with what mirrors do.

    An axis that is folded by one or both symmetries holds the nodes of a half or a quarter.

    Attributes:
        points: number of unknowns along the axis, n.
        lengthwise: functions are even in ν.
        crosswise: functions are the same at ν and π − ν.
    """

    points: int
    lengthwise: bool
    crosswise: bool

    # Whether kernels act on the even and the odd part of what is on all of the axis (spectral.py).
    in_halves = False

    @property
    def folded(self) -> bool:
        return self.lengthwise or self.crosswise

    @property
    def full_points(self) -> int:
        """Nodes all around."""
        return self.points * 2**self.lengthwise * 2**self.crosswise

    @cached_property
    def all_nodes(self) -> np.ndarray:
        """Nodes all around, those that carry unknowns first, shape (full_points,)."""
        return self._start + 2 * np.pi * (np.arange(self.full_points) + 0.5) / self.full_points

    @property
    def nodes(self) -> np.ndarray:
        """The nodes that carry unknowns, shape (n,)."""
        return self.all_nodes[: self.points]

    @property
    def inner(self) -> slice:
        """Which of all nodes carry unknowns."""
        return slice(0, self.points)

    @property
    def derivative(self) -> np.ndarray:
        """First derivative on all nodes, shape (full_points, full_points)."""
        return self._all.derivative

    @cached_property
    def second_derivative(self) -> np.ndarray:
        """Of a function of the axis' symmetries, shape (n, n)."""
        fourier, harmonics = self._all.fourier, self._all.harmonics
        return self._fold(-(fourier[:, : self.points].T * harmonics**2) @ fourier)

    @cached_property
    def weights(self) -> np.ndarray:
        """Of the mean over ν, shape (n,)."""
        return np.full(self.points, 1 / self.points)

    @cached_property
    def modes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Eigenvalues (n,), eigenvectors as columns of unit mean square and their inverse."""
        values, vectors = np.linalg.eigh(self.second_derivative)
        size = np.sqrt(self.points)
        return values[::-1], vectors[:, ::-1] * size, vectors[:, ::-1].T / size

    @property
    def in_parts(self) -> np.ndarray:
        """The second derivative, as kernels take it."""
        return self.second_derivative

    @property
    def modes_in_parts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """``modes`` likewise."""
        return self.modes

    @lru_cache(maxsize=64)  # noqa: B019 - axes are few and live as long as the process
    def moments(self, count: int) -> np.ndarray:
        """Rows that average a function times cos 2kν, k < count: (count, n)."""
        return np.cos(2 * np.outer(np.arange(count), self.nodes)) * self.weights

    @lru_cache(maxsize=64)  # noqa: B019 - axes are few and live as long as the process
    def interpolation_to(self, finer: Around) -> np.ndarray:
        """Matrix that carries values on this axis to another one, shape (finer.points, n)."""
        return self.at(finer.nodes)

    def to_points(self, places: np.ndarray) -> np.ndarray:
        """Matrix from values on all nodes to some places (m,), shape (m, full_points)."""
        return self._all.at(places - self.all_nodes[0])

    @property
    def unfolded(self) -> np.ndarray:
        """Which unknown each of all nodes has the value of, shape (full_points,)."""
        n, full = self.points, self.full_points
        index = np.arange(full)
        if self.lengthwise:
            index = np.minimum(index, full - 1 - index)
        if self.crosswise:
            # Mirrored about the end of the sector.
            index = np.where(index < n, index, 2 * n - 1 - index)
        return index

    @property
    def mirrored(self) -> list[np.ndarray]:
        """By each of its symmetries the nodes' images, of all nodes."""
        images = -self.all_nodes, np.pi - self.all_nodes
        step = 2 * np.pi / self.full_points
        return [
            np.round((image - self.all_nodes[0]) / step).astype(int) % self.full_points
            for image, has in zip(images, (self.lengthwise, self.crosswise), strict=True)
            if has
        ]

    def at(self, places: np.ndarray) -> np.ndarray:
        """Matrix from the unknowns to some places (m,), shape (m, n)."""
        return self._fold(self.to_points(places))

    @property
    def _all(self) -> Period:
        return period(self.full_points)

    @property
    def _start(self) -> float:
        """A half that is the same at ν and π − ν lies about 0."""
        return -np.pi / 2 if self.crosswise and not self.lengthwise else 0.0

    def _fold(self, matrix: np.ndarray) -> np.ndarray:
        """What the unknowns say of all, by the symmetry of what a matrix acts on."""
        folded = np.zeros((len(matrix), self.points))
        for at, column in zip(self.unfolded, matrix.T, strict=True):
            folded[:, at] += column
        return folded


@lru_cache(maxsize=64)
def around(points: int, lengthwise: bool, crosswise: bool) -> Around:
    """The axis with so many unknowns; its matrices are computed once."""
    return Around(points=points, lengthwise=lengthwise, crosswise=crosswise)
