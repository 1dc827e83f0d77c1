"""Films on the host, written apart from the kernels: fields, derivatives and means on one grid."""

from collections.abc import Sequence
from functools import cached_property, lru_cache

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.problems import Problems, problems_of
from squeezefilm.reynolds.spectral import Around, Axis, even_and_odd
from squeezefilm.reynolds.terms.rarefaction import (
    flow_over_viscous,
    slip_flow,
    slip_growth,
    slip_of,
)
from squeezefilm.solution import Solution


class AxisWithRim:
    """One axis with its rim nodes, if it ends there: derivatives and the mean over it.

    A folded axis holds one rim node and the first half of the others, on which a function even
    about the middle has an odd derivative and an odd one an even.

    Attributes:
        of_even, of_odd: first derivative of such functions, shape (m, m), m nodes with the rim;
            the same on an axis that is not folded.
        weights: of the integral of an even function, shape (m,), rim included.
    """

    def __init__(self, axis: Axis | Around) -> None:
        if isinstance(axis, Around):
            self.of_even, self.of_odd = axis.slope(odd=False), axis.slope(odd=True)
            self.weights = axis.weights
            return
        rim = 1 - axis.weights.sum()  # a constant's integral is that constant
        if axis.folded:
            self.of_even, self.of_odd = even_and_odd(axis.derivative)
            self.weights = np.append(rim, axis.weights)
        else:
            self.of_even = self.of_odd = axis.derivative
            self.weights = np.concatenate([[rim / 2], axis.weights, [rim / 2]])


with_rim = lru_cache(maxsize=64)(AxisWithRim)


class Fields:
    """Films of like terms on one grid, each with its gap H, pressure P and density ρ.

    Lengths in units of the pad's x side, time of 1/ω, pressure and density of ambient ones. Under
    an outline vectors are along its coordinates, times |dz/dζ|, and sources of mass times J, both
    over the typical (terms/outline.py).

    Every field has the shape (scenes, x, y, t), rim nodes included, a vector field (2, scenes, x,
    y, t). Numbers of scenes come as columns, to go with fields: ``number``.
    """

    def __init__(self, problems: Problems, grid: Grid, overpressure: np.ndarray) -> None:
        """Args: overpressure: P − 1 at the unknowns, shape (scenes, nx, ny, nt)."""
        self.problems, self.grid = problems, grid
        self.lengths = grid.lengths(problems.aspect)
        self.along_x, self.along_y = with_rim(grid.x), with_rim(grid.y)
        self.inner = (slice(None), grid.x.inner, grid.y.inner)
        across = grid.x.all_nodes[: len(self.along_x.weights)]
        self.area, self.turn, self.bend = (
            np.asarray(of(across))[..., None] for of in (grid.area, grid.turn, grid.bend)
        )
        seen = (..., slice(len(self.along_x.weights)), slice(len(self.along_y.weights)), None)
        parts = problems.parts[problems.places].swapaxes(0, 1)[seen]
        rest = 1 + self.numbers("per_rise", absent=0.0) * sum(parts[2:])
        moving = self.number(problems.numbers["epsilon"]) * parts[:2]
        sine, cosine = np.sin(grid.t.nodes), np.cos(grid.t.nodes)
        self.gap = rest + sum(map(np.multiply, moving, (sine, cosine)))
        self.gap_rate = sum(map(np.multiply, moving, (cosine, -sine)))
        self.overpressure = self.on_all_nodes(overpressure)

    def number(self, values: np.ndarray) -> np.ndarray:
        """One number of each scene, to go with fields."""
        return np.asarray(values, dtype=float)[:, None, None, None]

    def numbers(self, name: str, *, absent: float) -> np.ndarray:
        """A number that a term gives the scenes, or what it is without the term."""
        table = self.problems.numbers
        known = name in (table.dtype.names or ())
        return self.number(table[name] if known else np.full(len(table), absent))

    def on_all_nodes(self, values: np.ndarray) -> np.ndarray:
        """Values at the unknowns with zeros on the rim."""
        found = np.zeros(self.gap.shape)
        found[self.inner] = values
        return found

    @cached_property
    def sigma(self) -> np.ndarray:
        return self.number(self.problems.numbers["sigma"])

    @cached_property
    def density(self) -> np.ndarray:
        exponent, pressure = self.numbers("inverse_exponent", absent=1.0), 1 + self.overpressure
        return pressure if np.all(exponent == 1) else np.asarray(pressure**exponent)

    @cached_property
    def density_slope(self) -> np.ndarray:
        """dρ/dP."""
        exponent = self.numbers("inverse_exponent", absent=1.0)
        return np.asarray(exponent * self.density / (1 + self.overpressure))

    @cached_property
    def mass(self) -> np.ndarray:
        """Hρ, the mass of gas per area."""
        return np.asarray(self.gap * self.density)

    @cached_property
    def pressure_rate(self) -> np.ndarray:
        """∂P/∂T."""
        return self.t_derivative(self.overpressure)

    @cached_property
    def slope(self) -> np.ndarray:
        """∇P."""
        return self.gradient(self.overpressure)

    @cached_property
    def velocity(self) -> np.ndarray:
        """Mean velocity over the gap by pressure alone, ū = −(1/σ) ``mobility`` ∇P."""
        return self.slope * (self.mobility * (-1 / self.sigma))

    @cached_property
    def mobility(self) -> np.ndarray:
        """H² W, by which a slope of pressure drives gas: W is the flow over a viscous gas'."""
        return np.asarray(flow_over_viscous(self.problems.numbers, self.mass) * self.gap**2)

    @cached_property
    def flow_terms(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray | float]]:
        """c_k H^(3−k), dg_k/dP and d²g_k/dP² of each term of the flux Σ c_k H^(3−k) ∇g_k.

        They are the terms of film_over_period.cl, the second derivative that of an isothermal gas.
        """
        square = self.gap**2
        cube = self.gap * square
        if self.problems.numbers["flow"].shape[1] == 1:
            return [(cube, self.density, 1.0)]
        slip, inverse = slip_of(self.problems.numbers, self.mass)
        if inverse is None:
            return [(cube, self.density, 1.0), (slip * square, np.ones_like(square), 0.0)]
        over_gap, flow, (growth, bend) = slip / self.gap, slip_flow(inverse), slip_growth(inverse)
        return [
            (cube, self.density + over_gap * growth, 1 + over_gap / self.density * bend),
            (slip * square, flow - growth, (growth - bend) / self.density),
        ]

    def x_derivative(self, values: np.ndarray, *, odd: bool = False) -> np.ndarray:
        """∂/∂X of a field that is even in x, or odd, wherever the axis is folded."""
        matrix = self.along_x.of_odd if odd else self.along_x.of_even
        return along_x(matrix / self.lengths[0], values)

    def y_derivative(self, values: np.ndarray, *, odd: bool = False) -> np.ndarray:
        matrix = self.along_y.of_odd if odd else self.along_y.of_even
        return along_y(matrix / self.lengths[1], values)

    def slide(self, values: np.ndarray) -> np.ndarray:
        """∂/∂X along the pad's own x axis."""
        if self.grid.outline is None:
            return self.x_derivative(values)
        return self.turn.real * self.x_derivative(values) - self.turn.imag * self.y_derivative(
            values
        )

    def t_derivative(self, values: np.ndarray) -> np.ndarray:
        return along_t(self.grid.t.derivative, values)

    def gradient(self, values: np.ndarray) -> np.ndarray:
        return np.stack([self.x_derivative(values), self.y_derivative(values)])

    def divergence(self, flux: np.ndarray) -> np.ndarray:
        return self.x_derivative(flux[0], odd=True) + self.y_derivative(flux[1], odd=True)

    def carried(self, v: np.ndarray) -> np.ndarray:
        """(v·∇)v of a velocity (terms/inertia.py)."""
        along = self.x_derivative(v[0], odd=True), self.x_derivative(v[1])
        across = self.y_derivative(v[0]), self.y_derivative(v[1], odd=True)
        bends = -self.bend.real, self.bend.imag
        square = dot(v, v) if self.grid.outline else 0.0
        parts = zip(along, across, bends, strict=True)
        return np.stack([v[0] * x + v[1] * y + bend * square for x, y, bend in parts]) / self.area

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean over film and period, shape (scenes,)."""
        return np.einsum("si,i->s", values.reshape(len(values), -1), self.weights)

    @cached_property
    def weights(self) -> np.ndarray:
        """Return the weights of the mean over film and period, (nodes · times,) in sequence."""
        return np.ravel(self.plain_weights * (self.area * self.grid.mean_area))

    @cached_property
    def plain_weights(self) -> np.ndarray:
        """Weights of the mean over the coordinates, (x, y, t)."""
        area = np.outer(self.along_x.weights, self.along_y.weights)
        return np.repeat(area[..., None] / self.grid.nt, self.grid.nt, axis=2)


def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Product of two vector fields."""
    return np.asarray(one[0] * other[0] + one[1] * other[1])


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


def fields_of(scenes: Sequence[Scene], solutions: Sequence[Solution], *, grid: int = -1) -> Fields:
    """The films of ``alike`` scenes, by default on the finer grid."""
    states = [solution.states[grid] for solution in solutions]
    problems = problems_of(scenes, states[0].grid)
    return Fields(problems, states[0].grid, np.stack([each.unknowns[0] for each in states]))


def residual(films: Fields) -> np.ndarray:
    """Return the residual of the film equation at the unknowns.

    The residual is ∇·(W H³ρ ∇P) − σ ∂(Hρ)/∂T − Λ ∂(Hρ)/∂X, W the flow over a viscous gas',
    of shape (scenes, nx, ny, nt).
    """
    flow = films.divergence(films.slope * (films.mobility * films.mass))
    moved = films.sigma * films.area * films.t_derivative(films.mass)
    moved += films.numbers("bearing", absent=0.0) * films.slide(films.mass)
    return np.asarray((flow - moved)[films.inner])
