"""Modes of an elliptical pad: eigenfunctions of the Laplacian that vanish on its rim.

The unit disc u = (2x/a, 2y/b) carries the polynomials (1 − ρ²) ρ^m P_k^(2,m)(2ρ² − 1) cos or sin mθ
of degree m + 2k ≤ ``degree`` (besides 1 − ρ²); the modes of the ellipse are found in their span, so
that mass and stiffness are diagonal there whatever the aspect.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import ceil

import numpy as np


@dataclass(frozen=True)
class PadGrid:
    """What a pad's modes are taken from.

    Attributes:
        degree: of the polynomials.
        aspect: axis along y over that along x.
        fold_x, fold_y: only modes even about the middle along x, y.
    """

    degree: int
    aspect: float
    fold_x: bool
    fold_y: bool

    @property
    def radial_points(self) -> int:
        """Gauss points along the radius: half as many again as the modes' products need."""
        return ceil(0.75 * (self.degree + 4))

    @property
    def angles(self) -> int:
        """Equidistant angles around, likewise."""
        return 4 * ceil(0.75 * (self.degree + 2))


@dataclass(frozen=True)
class PadModes:
    """Orthonormal modes, in the sense of the mean over the pad, at Q quadrature points.

    Attributes:
        x, y: the points, in [0, 1] across the pad's bounding box, shape (Q,).
        weights: of the mean over the pad, sum 1, shape (Q,).
        values, along_x, along_y: modes and their derivatives, lengths in units of the pad's axis
            along x, shape (Q, modes).
        eigenvalues: of the negative Laplacian, rising, shape (modes,).
        orders: (m, k) of the polynomials, m < 0 for sines.
        vectors: modes in terms of the polynomials, shape (polynomials, modes).
        mass: the polynomials' products, shape (polynomials, polynomials).
    """

    x: np.ndarray
    y: np.ndarray
    weights: np.ndarray
    values: np.ndarray
    along_x: np.ndarray
    along_y: np.ndarray
    eigenvalues: np.ndarray
    orders: tuple[tuple[int, int], ...]
    vectors: np.ndarray
    mass: np.ndarray

    def carried_to(self, finer: PadModes) -> np.ndarray:
        """Matrix from coefficients here to coefficients there, shape (finer's modes, modes)."""
        place = {order: row for row, order in enumerate(finer.orders)}
        raw = np.zeros((len(finer.orders), self.vectors.shape[1]))
        for row, order in enumerate(self.orders):
            raw[place[order]] = self.vectors[row]
        carried: np.ndarray = finer.vectors.T @ (finer.mass @ raw)
        return carried


@lru_cache(maxsize=8)
def pad_modes(grid: PadGrid) -> PadModes:
    """The modes of a pad; computed once."""
    from scipy.linalg import eigh

    u, v, weights = _quadrature(grid)
    orders = _orders(grid)
    values, along_u, along_v = _polynomials(orders, u, v)
    along_x, along_y = 2 * along_u, 2 / grid.aspect * along_v
    mass = values.T @ (weights[:, None] * values)
    stiffness = along_x.T @ (weights[:, None] * along_x)
    stiffness += along_y.T @ (weights[:, None] * along_y)
    size = 1 / np.sqrt(np.diag(mass))  # polynomials of unit mean square, for the conditioning
    eigenvalues, vectors = eigh(size[:, None] * stiffness * size, size[:, None] * mass * size)
    vectors = size[:, None] * vectors
    return PadModes(
        x=(1 + u) / 2,
        y=(1 + v) / 2,
        weights=weights,
        values=values @ vectors,
        along_x=along_x @ vectors,
        along_y=along_y @ vectors,
        eigenvalues=eigenvalues,
        orders=orders,
        vectors=vectors,
        mass=mass,
    )


def _quadrature(grid: PadGrid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points u, v of the unit disc, on the part that symmetry leaves, and weights of the mean."""
    nodes, shares = np.polynomial.legendre.leggauss(grid.radial_points)
    radius = np.sqrt((1 + nodes) / 2)  # Gauss in ρ², which the area element makes even
    angle = 2 * np.pi * (np.arange(grid.angles) + 0.5) / grid.angles
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
