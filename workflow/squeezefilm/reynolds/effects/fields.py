"""A batch of periodic films as fields on all nodes of one grid, rim included, with derivatives.

Host arithmetic on coarse grids: an effect of a per cent need not be known to more than two digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache, reduce

import numpy as np

from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.problems import Problems
from squeezefilm.reynolds.spectral import Axis

DOUBLE = np.dtype(np.float64)


@dataclass(frozen=True)
class Lines:
    """One axis with its rim nodes: derivatives and the integral over [0, 1].

    A folded axis holds one rim node and the first half of the others, on which a function even
    about the middle has an odd derivative and an odd one an even.

    Attributes:
        of_even, of_odd: first derivative of such functions, shape (m, m), m nodes with the rim;
            the same on an axis that is not folded.
        weights: of the integral of an even function, shape (m,), rim included.
    """

    of_even: np.ndarray
    of_odd: np.ndarray
    weights: np.ndarray


@lru_cache(maxsize=64)
def lines_of(axis: Axis, kind: np.dtype[np.floating] = DOUBLE) -> Lines:
    """An axis' lines, in numbers of a kind; one rim node for both if it is folded."""
    if kind != DOUBLE:
        known = lines_of(axis)
        return Lines(*(each.astype(kind) for each in vars(known).values()))
    if not axis.folded:
        end = (1 - axis.weights.sum()) / 2  # a constant's integral is that constant
        return Lines(axis.derivative, axis.derivative, np.concatenate([[end], axis.weights, [end]]))
    half = axis.points + 1
    near, far = axis.derivative[:half, :half], axis.derivative[:half, : half - 1 : -1]
    weights = np.concatenate([[1 - axis.weights.sum()], axis.weights])
    return Lines(near + far, near - far, weights)


@dataclass(frozen=True)
class Vector:
    """A vector field in the plane of the film: its parts along x and y, each (scenes, x, y, t)."""

    x: np.ndarray
    y: np.ndarray

    def times(self, factor: np.ndarray | float) -> Vector:
        return Vector(factor * self.x, factor * self.y)

    def plus(self, other: Vector) -> Vector:
        return Vector(self.x + other.x, self.y + other.y)

    def dot(self, other: Vector) -> np.ndarray:
        return np.asarray(self.x * other.x + self.y * other.y)


class Fields:
    """Films of like terms on one grid, each with its gap H, pressure P and density ρ.

    Lengths in units of the finger's x side, time of 1/ω, pressure and density of ambient ones.
    Every field has the shape (scenes, x, y, t), rim nodes included. Numbers of scenes come as
    columns, to go with fields: ``number``. All are of the overpressure's kind, single or double.
    """

    def __init__(self, problems: Problems, grid: Grid, overpressure: np.ndarray) -> None:
        """Args: overpressure: P − 1 at the unknowns, shape (scenes, nx, ny, nt)."""
        if not isinstance(grid.y, Axis):
            raise ValueError("what is beside the force is known of rectangular pads alone")
        self.problems, self.grid, self.kind = problems, grid, overpressure.dtype
        self.along_x, self.along_y = lines_of(grid.x, self.kind), lines_of(grid.y, self.kind)
        self.inner = (slice(None), slice(1, grid.nx + 1), slice(1, grid.ny + 1))
        seen = (..., slice(len(self.along_x.weights)), slice(len(self.along_y.weights)), None)
        parts = problems.parts.astype(self.kind)[problems.places].swapaxes(0, 1)[seen]
        self._moving = self.number(problems.epsilon) * parts[:2]
        rest = 1 + self.numbers("per_rise", absent=0.0) * sum(parts[2:])
        self._sin, self._cos = (f(grid.t.nodes).astype(self.kind) for f in (np.sin, np.cos))
        self.gap = self._moved(self._sin, self._cos)
        self.gap += rest
        self.overpressure = self.with_rim(overpressure)

    def _moved(self, *shares: np.ndarray) -> np.ndarray:
        """Sum of such shares of the gap's moving parts."""
        return np.asarray(reduce(np.add, map(np.multiply, self._moving, shares)))

    def number(self, values: np.ndarray) -> np.ndarray:
        """One number of each scene, to go with fields."""
        return np.asarray(values, dtype=self.kind)[:, None, None, None]

    def numbers(self, name: str, *, absent: float) -> np.ndarray:
        """A number that a term gives the scenes, or what it is without the term."""
        table = self.problems.numbers
        known = name in (table.dtype.names or ())
        return self.number(table[name] if known else np.full(len(table), absent))

    def with_rim(self, values: np.ndarray) -> np.ndarray:
        """Values at the unknowns with zeros on the rim."""
        found = np.zeros(self.gap.shape, self.kind)
        found[self.inner] = values
        return found

    @cached_property
    def sigma(self) -> np.ndarray:
        return self.number(self.problems.sigma)

    @cached_property
    def _exponent(self) -> np.ndarray | None:
        """That of ρ = P^exponent; None for an isothermal gas."""
        known = "inverse_exponent" in (self.problems.numbers.dtype.names or ())
        return self.number(self.problems.numbers["inverse_exponent"]) if known else None

    @cached_property
    def gap_rate(self) -> np.ndarray:
        """∂H/∂T."""
        return self._moved(self._cos, -self._sin)

    @cached_property
    def pressure(self) -> np.ndarray:
        return 1 + self.overpressure

    @cached_property
    def density(self) -> np.ndarray:
        exponent = self._exponent
        return self.pressure if exponent is None else np.asarray(self.pressure**exponent)

    @cached_property
    def density_slope(self) -> np.ndarray:
        """dρ/dP, of an isothermal gas one number."""
        if self._exponent is None:
            return np.ones((1, 1, 1, 1), self.kind)
        return np.asarray(self._exponent * self.density / self.pressure)

    @cached_property
    def mass(self) -> np.ndarray:
        """Hρ, the mass of gas per area."""
        return np.asarray(self.gap * self.density)

    @cached_property
    def mass_rate(self) -> np.ndarray:
        """∂(Hρ)/∂T."""
        rate = self.gap_rate * self.density
        rate += self.gap * self.pressure_rate * self.density_slope
        return np.asarray(rate)

    @cached_property
    def pressure_rate(self) -> np.ndarray:
        """∂P/∂T."""
        return self.t_derivative(self.overpressure)

    @cached_property
    def slope(self) -> Vector:
        """∇P."""
        return self.gradient(self.overpressure)

    @cached_property
    def velocity(self) -> Vector:
        """Mean velocity over the gap by pressure alone, ū = −(1/σ) Σ c_k H^(2−k) ρ^(−k) ∇P."""
        return self.slope.times(self.ease * (-1 / self.sigma))

    @cached_property
    def ease(self) -> np.ndarray:
        """Σ c_k H^(2−k) ρ^(−k), by which a slope of pressure drives gas; H² without slip."""
        first, *rest = (self.number(c) for c in self.problems.numbers["flow"].T)
        factor = first
        for k, coefficient in enumerate(rest, start=1):
            factor = factor + coefficient / self.mass**k
        return np.asarray(factor * self.gap**2)

    @cached_property
    def flows(self) -> list[np.ndarray]:
        """c_k H^(3−k) of each term of the flow; NumPy is quick at squares alone."""
        flow = self.problems.numbers["flow"]
        return [self.number(c) * (self.gap * self.gap ** (2 - k)) for k, c in enumerate(flow.T)]

    def x_derivative(self, values: np.ndarray, *, odd: bool = False) -> np.ndarray:
        """∂/∂X of a field that is even in x, or odd, wherever the axis is folded."""
        return along_x(self.along_x.of_odd if odd else self.along_x.of_even, values)

    def y_derivative(self, values: np.ndarray, *, odd: bool = False) -> np.ndarray:
        matrix = self.along_y.of_odd if odd else self.along_y.of_even
        return along_y(matrix / self.problems.aspect, values)

    def t_derivative(self, values: np.ndarray) -> np.ndarray:
        return along_t(self.time_derivative, values)

    def gradient(self, values: np.ndarray) -> Vector:
        return Vector(self.x_derivative(values), self.y_derivative(values))

    def divergence(self, flux: Vector) -> np.ndarray:
        return self.x_derivative(flux.x, odd=True) + self.y_derivative(flux.y, odd=True)

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean over film and period, shape (scenes,)."""
        return np.einsum("si,i->s", values.reshape(len(values), -1), self.weights)

    @cached_property
    def weights(self) -> np.ndarray:
        """Of the mean over film and period, shape (nodes,), all of them behind each other."""
        area = np.outer(self.along_x.weights, self.along_y.weights)
        return np.repeat(area.ravel() / self.grid.nt, self.grid.nt)

    @cached_property
    def time_derivative(self) -> np.ndarray:
        """∂/∂T on the nodes, shape (nt, nt)."""
        return self.grid.t.derivative.astype(self.kind)


def along_x(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A matrix (m, n) along the first axis of fields (scenes, n, y, t)."""
    scenes, nodes = values.shape[:2]
    product = matrix @ values.reshape(scenes, nodes, -1)
    return np.asarray(product.reshape(scenes, len(matrix), *values.shape[2:]))


def along_y(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A matrix (m, n) along the second axis of fields (scenes, x, n, t)."""
    return np.asarray(matrix @ values)


def along_t(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A matrix (m, n) along the last axis of fields (scenes, x, y, n)."""
    product = values.reshape(len(values), -1, values.shape[-1]) @ matrix.T
    return np.asarray(product.reshape(*values.shape[:-1], len(matrix)))
