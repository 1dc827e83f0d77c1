"""Modes of a pad: eigenfunctions of the Laplacian that vanish on its rim.

They are found among polynomials that vanish there, so that mass and stiffness are diagonal:

    rectangle   products of (1 − t²) P_k^(2,2)(t), t = 2x/a and 2y/b, k ≤ ``degree``
    ellipse     (1 − ρ²) ρ^m P_k^(2,m)(2ρ² − 1) cos or sin mθ, m + 2k ≤ ``degree``, on the unit disc
                of 2x/a, 2y/b

Fields are given at Q quadrature points and some instants, (Q, instants), sums of modes by their
coefficients, (modes, instants). The product ⟨·,·⟩ is the mean over the pad, in which the modes are
orthonormal; lengths are in units of the pad's length along x.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil
from typing import Any, Protocol

import numpy as np


@dataclass(frozen=True)
class PadGrid:
    """What a pad's modes are taken from.

    Attributes:
        shape: ``rectangle`` or ``ellipse``.
        degree: of the polynomials.
        aspect: length along y over that along x.
        fold_x, fold_y: only modes even about the middle along x, y.
    """

    shape: str
    degree: int
    aspect: float
    fold_x: bool
    fold_y: bool

    @property
    def points(self) -> tuple[int, int]:
        """Quadrature points along x and y, or along a radius and around, without folds.

        Half as many again as the modes' products need, for the powers of the gap.
        """
        if self.shape == "ellipse":
            return ceil(0.75 * (self.degree + 4)), 4 * ceil(0.75 * (self.degree + 2))
        across = 2 * ceil(0.75 * (self.degree + 4))
        return across, across

    @property
    def modes(self) -> float:
        """About how many modes there are."""
        full = (self.degree + 1) * (self.degree + 2) / 2
        return (full if self.shape == "ellipse" else 2 * full) / self.folds

    @property
    def folds(self) -> int:
        """How many mirror images the modes stand for, with themselves."""
        return 2**self.fold_x * 2**self.fold_y

    @property
    def flops(self) -> float:
        """Floating-point operations of one product with all modes or their slopes."""
        if self.shape == "ellipse":
            return 2.0 * self.modes * self.points[0] * self.points[1] / self.folds
        return 4.0 * self.modes * (self.points[0] + self.points[1])


class PadModes(Protocol):
    """A pad's modes.

    Attributes:
        x, y: the quadrature points, in [0, 1] across the pad, shape (Q,).
        weights: of the mean over the pad, sum 1, shape (Q,).
        eigenvalues: of the negative Laplacian, shape (modes,).
    """

    @property
    def x(self) -> np.ndarray: ...

    @property
    def y(self) -> np.ndarray: ...

    @property
    def weights(self) -> np.ndarray: ...

    @property
    def eigenvalues(self) -> np.ndarray: ...

    def values(self, coefficients: np.ndarray) -> np.ndarray:
        """A sum of modes at the points."""
        ...

    def slopes(self, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Its derivatives along x and y."""
        ...

    def project(self, field: np.ndarray) -> np.ndarray:
        """⟨φ_i, field⟩: its coefficients, if it vanishes on the rim."""
        ...

    def project_on_slopes(self, along_x: np.ndarray, along_y: np.ndarray | None) -> np.ndarray:
        """⟨∂φ_i/∂x, along_x⟩ + ⟨∂φ_i/∂y, along_y⟩."""
        ...

    def at(self, x: np.ndarray, y: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        """A sum of modes at other points, x and y of shape (N,): (N, instants)."""
        ...

    def carry(self, coefficients: np.ndarray, finer: Any) -> np.ndarray:
        """The coefficients of the same sum in the modes of a finer grid of this pad."""
        ...


@lru_cache(maxsize=8)
def pad_modes(grid: PadGrid) -> PadModes:
    """The modes of a pad; computed once."""
    return _disc_modes(grid) if grid.shape == "ellipse" else _rectangle_modes(grid)


@dataclass(frozen=True)
class _Basis:
    """Modes in terms of polynomials: ``vectors`` (polynomials, modes), the polynomials' products
    ``mass`` and their names ``orders``."""

    orders: tuple[Any, ...]
    vectors: np.ndarray
    mass: np.ndarray
    eigenvalues: np.ndarray

    def to(self, finer: _Basis) -> np.ndarray:
        """Matrix from coefficients here to coefficients there."""
        place = {order: row for row, order in enumerate(finer.orders)}
        raw = np.zeros((len(finer.orders), self.vectors.shape[1]))
        raw[[place[order] for order in self.orders]] = self.vectors
        carried: np.ndarray = finer.vectors.T @ (finer.mass @ raw)
        return carried


def _diagonal(orders: tuple[Any, ...], *, mass: np.ndarray, stiffness: np.ndarray) -> _Basis:
    """The modes that make mass and stiffness diagonal, the first to the identity."""
    from scipy.linalg import eigh

    size = 1 / np.sqrt(np.diag(mass))  # polynomials of unit mean square, for the conditioning
    values, vectors = eigh(size[:, None] * stiffness * size, size[:, None] * mass * size)
    return _Basis(orders, size[:, None] * vectors, mass, values)


@dataclass(frozen=True)
class _Line:
    """Modes across a rectangle, along one of its sides: values and slopes are (points, modes)."""

    nodes: np.ndarray
    weights: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    basis: _Basis

    def at(self, places: np.ndarray) -> np.ndarray:
        """The modes' values at other places in [0, 1], (places, modes)."""
        values, _ = _line_polynomials(self.basis.orders, 2 * places - 1)
        return values @ self.basis.vectors


def _line_polynomials(orders: tuple[int, ...], t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and derivatives along t in [−1, 1], each (points, polynomials)."""
    from scipy.special import eval_jacobi

    values, slopes = np.empty((len(t), len(orders))), np.empty((len(t), len(orders)))
    for index, k in enumerate(orders):
        factor = eval_jacobi(k, 2, 2, t)
        rate = (k + 5) / 2 * eval_jacobi(k - 1, 3, 3, t) if k else 0.0
        values[:, index] = (1 - t**2) * factor
        slopes[:, index] = (1 - t**2) * rate - 2 * t * factor
    return values, slopes


def _line(*, degree: int, points: int, length: float, fold: bool) -> _Line:
    t, shares = np.polynomial.legendre.leggauss(points)
    if fold:
        t, shares = t[t < 0], 2 * shares[t < 0]
    orders = tuple(range(0, degree + 1, 2 if fold else 1))
    values, slopes = _line_polynomials(orders, t)
    slopes *= 2 / length
    weights = shares / 2
    mass = values.T @ (weights[:, None] * values)
    basis = _diagonal(orders, mass=mass, stiffness=slopes.T @ (weights[:, None] * slopes))
    return _Line((1 + t) / 2, weights, values @ basis.vectors, slopes @ basis.vectors, basis)


@dataclass(frozen=True)
class _RectangleModes:
    """Products of modes along the sides; sums are taken one direction after the other."""

    along_x: _Line
    along_y: _Line

    @cached_property
    def x(self) -> np.ndarray:
        return np.repeat(self.along_x.nodes, len(self.along_y.nodes))

    @cached_property
    def y(self) -> np.ndarray:
        return np.tile(self.along_y.nodes, len(self.along_x.nodes))

    @cached_property
    def weights(self) -> np.ndarray:
        return np.outer(self.along_x.weights, self.along_y.weights).ravel()

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        values_x, values_y = self.along_x.basis.eigenvalues, self.along_y.basis.eigenvalues
        return np.add.outer(values_x, values_y).ravel()

    def values(self, coefficients: np.ndarray) -> np.ndarray:
        return _products(self.along_x.values, self.along_y.values, coefficients)

    def slopes(self, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (
            _products(self.along_x.slopes, self.along_y.values, coefficients),
            _products(self.along_x.values, self.along_y.slopes, coefficients),
        )

    def project(self, field: np.ndarray) -> np.ndarray:
        weighted = self.weights[:, None] * field
        return _products(self.along_x.values.T, self.along_y.values.T, weighted)

    def project_on_slopes(self, along_x: np.ndarray, along_y: np.ndarray | None) -> np.ndarray:
        weighted = self.weights[:, None] * along_x
        total = _products(self.along_x.slopes.T, self.along_y.values.T, weighted)
        if along_y is not None:
            weighted = self.weights[:, None] * along_y
            total += _products(self.along_x.values.T, self.along_y.slopes.T, weighted)
        return total

    def at(self, x: np.ndarray, y: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        values_x, values_y = self.along_x.at(x), self.along_y.at(y)
        table = coefficients.reshape(values_x.shape[1], values_y.shape[1], -1)
        return np.einsum("ni,nj,ijt->nt", values_x, values_y, table, optimize=True)

    def carry(self, coefficients: np.ndarray, finer: _RectangleModes) -> np.ndarray:
        to_x = self.along_x.basis.to(finer.along_x.basis)
        to_y = self.along_y.basis.to(finer.along_y.basis)
        return _products(to_x, to_y, coefficients)


def _products(a: np.ndarray, b: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """(a ⊗ b) columns, one direction after the other."""
    instants = columns.shape[1]
    first = a @ columns.reshape(a.shape[1], -1)
    second = b @ first.reshape(a.shape[0], b.shape[1], instants)
    return second.reshape(-1, instants)


def _rectangle_modes(grid: PadGrid) -> _RectangleModes:
    lines = [
        _line(degree=grid.degree, points=points, length=length, fold=fold)
        for points, length, fold in zip(
            grid.points, (1.0, grid.aspect), (grid.fold_x, grid.fold_y), strict=True
        )
    ]
    return _RectangleModes(*lines)


@dataclass(frozen=True)
class _DiscModes:
    """Modes of an ellipse as matrices, (Q, modes)."""

    x: np.ndarray
    y: np.ndarray
    weights: np.ndarray
    at_points: np.ndarray
    along_x: np.ndarray
    along_y: np.ndarray
    basis: _Basis

    @property
    def eigenvalues(self) -> np.ndarray:
        return self.basis.eigenvalues

    def values(self, coefficients: np.ndarray) -> np.ndarray:
        return self.at_points @ coefficients

    def slopes(self, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.along_x @ coefficients, self.along_y @ coefficients

    def project(self, field: np.ndarray) -> np.ndarray:
        return self.at_points.T @ (self.weights[:, None] * field)

    def project_on_slopes(self, along_x: np.ndarray, along_y: np.ndarray | None) -> np.ndarray:
        total = self.along_x.T @ (self.weights[:, None] * along_x)
        if along_y is not None:
            total += self.along_y.T @ (self.weights[:, None] * along_y)
        return total

    def at(self, x: np.ndarray, y: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        values, _, _ = _polynomials(self.basis.orders, 2 * x - 1, 2 * y - 1)
        return values @ (self.basis.vectors @ coefficients)

    def carry(self, coefficients: np.ndarray, finer: _DiscModes) -> np.ndarray:
        return self.basis.to(finer.basis) @ coefficients


def _disc_modes(grid: PadGrid) -> _DiscModes:
    u, v, weights = _quadrature(grid)
    orders = _orders(grid)
    values, along_u, along_v = _polynomials(orders, u, v)
    along_x, along_y = 2 * along_u, 2 / grid.aspect * along_v
    mass = values.T @ (weights[:, None] * values)
    stiffness = along_x.T @ (weights[:, None] * along_x)
    stiffness += along_y.T @ (weights[:, None] * along_y)
    basis = _diagonal(orders, mass=mass, stiffness=stiffness)
    return _DiscModes(
        x=(1 + u) / 2,
        y=(1 + v) / 2,
        weights=weights,
        at_points=values @ basis.vectors,
        along_x=along_x @ basis.vectors,
        along_y=along_y @ basis.vectors,
        basis=basis,
    )


def _quadrature(grid: PadGrid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points u, v of the unit disc, on the part that symmetry leaves, and weights of the mean."""
    radii, angles = grid.points
    nodes, shares = np.polynomial.legendre.leggauss(radii)
    radius = np.sqrt((1 + nodes) / 2)  # Gauss in ρ², which the area element makes even
    angle = 2 * np.pi * (np.arange(angles) + 0.5) / angles
    if grid.fold_x:
        angle = angle[np.cos(angle) > 0]
    if grid.fold_y:
        angle = angle[np.sin(angle) > 0]
    u, v = np.outer(radius, np.cos(angle)).ravel(), np.outer(radius, np.sin(angle)).ravel()
    return u, v, np.repeat(shares / 2, len(angle)) / len(angle)


def _orders(grid: PadGrid) -> tuple[tuple[int, int], ...]:
    """(m, k) of the polynomials that are as even as the fold asks; m < 0 stands for a sine.

    Along x, cos mθ is even for even m and sin mθ for odd; along y every cosine is and no sine.
    """
    return tuple(
        (m, k)
        for m in range(-grid.degree, grid.degree + 1)
        for k in range((grid.degree - abs(m)) // 2 + 1)
        if not (grid.fold_y and m < 0) and not (grid.fold_x and (m % 2 == 0) == (m < 0))
    )


def _polynomials(
    orders: tuple[tuple[int, int], ...], u: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values and derivatives along u and v, each (points, polynomials)."""
    from scipy.special import eval_jacobi

    square, turned = u**2 + v**2, u + 1j * v
    t = 2 * square - 1
    values, along_u, along_v = (np.empty((len(u), len(orders))) for _ in range(3))
    for index, (signed, k) in enumerate(orders):
        m = abs(signed)
        radial = eval_jacobi(k, 2, m, t)
        slope = (k + m + 3) / 2 * eval_jacobi(k - 1, 3, m + 1, t) if k else 0.0
        factor = (1 - square) * radial
        rate = 2 * (1 - square) * slope - radial  # d factor / d(ρ²)
        power = turned**m
        before = m * turned ** (m - 1) if m else np.zeros_like(turned)
        part = np.imag if signed < 0 else np.real
        values[:, index] = factor * part(power)
        along_u[:, index] = 2 * u * rate * part(power) + factor * part(before)
        along_v[:, index] = 2 * v * rate * part(power) + factor * part(1j * before)
    return values, along_u, along_v
