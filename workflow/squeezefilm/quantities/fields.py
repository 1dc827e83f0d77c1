"""Fields of films on the host: gap, mass, velocity by pressure, and their derivatives on one grid.

Every field has the shape (scenes, x, y, t), edge nodes included, a vector field (2, scenes, x, y,
t). Lengths in units of the pad's x side, time of 1/ω, pressure and density of ambient ones. Under
an outline vectors are along its coordinates, times |dz/dζ|, and sources of mass times J, both over
the typical (reynolds/terms/outline.py).
"""

from collections.abc import Sequence
from functools import cached_property, lru_cache

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.states import weights_with_edge
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.packing import gap_parts, numbers_table, terms_of_all
from squeezefilm.reynolds.spectral import Around, Axis, even_and_odd
from squeezefilm.reynolds.terms.rarefaction import flow_over_viscous


@lru_cache(maxsize=64)
def derivatives_with_edge(axis: Axis | Around) -> tuple[np.ndarray, np.ndarray]:
    """Derivative of an even and of an odd function on all nodes, (m, m); alike if not folded.

    A folded axis holds one edge node and the first half of the others, on which a function even
    about the middle has an odd derivative and an odd one an even.
    """
    if isinstance(axis, Around):
        return axis.slope(odd=False), axis.slope(odd=True)
    even, odd = even_and_odd(axis.derivative) if axis.folded else (axis.derivative,) * 2
    return even, odd


class Fields:
    """Films of like terms on one grid, each with its gap H, pressure P and density ρ.

    ``equation`` has the numbers of each scene's equation; they come as columns, to go with fields:
    ``number``.
    """

    def __init__(
        self, scenes: Sequence[Scene], grid: Grid, gauge_pressure_ratio: np.ndarray
    ) -> None:
        """Args: gauge pressure: P − 1 at the unknowns, shape (scenes, nx, ny, nt)."""
        self.grid, scenes = grid, Scenes.of(scenes)
        self.equation = numbers_table(scenes, terms_of_all(scenes))
        self.lengths = grid.lengths(scenes[0].aspect)
        self.inner = (slice(None), grid.x.inner, grid.y.inner)
        nodes = [len(weights_with_edge(axis)) for axis in (grid.x, grid.y)]
        across = grid.x.all_nodes[: nodes[0]]
        self.area, self.turn, self.bend = (
            np.asarray(of(across))[..., None] for of in (grid.area, grid.turn, grid.bend)
        )
        seen = (..., slice(nodes[0]), slice(nodes[1]), None)
        parts = gap_parts(scenes, grid).swapaxes(0, 1)[seen]
        self.rest_gap = 1 + self.numbers("per_rise", absent=0.0) * sum(parts[2:])
        moving = self.number(self.equation["epsilon"]) * parts[:2]
        sine, cosine = np.sin(grid.t.nodes), np.cos(grid.t.nodes)
        self.gap = self.rest_gap + sum(map(np.multiply, moving, (sine, cosine)))
        self.gauge_pressure_ratio = self.on_all_nodes(gauge_pressure_ratio)

    def number(self, values: np.ndarray) -> np.ndarray:
        """One number of each scene, to go with fields."""
        return np.asarray(values, dtype=float)[:, None, None, None]

    def numbers(self, name: str, *, absent: float) -> np.ndarray:
        """A number that a term gives the scenes, or what it is without the term."""
        known = name in (self.equation.dtype.names or ())
        return self.number(self.equation[name] if known else np.full(len(self.equation), absent))

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean over film and period, shape (..., scenes)."""
        along, around = (weights_with_edge(axis) for axis in (self.grid.x, self.grid.y))
        over_pad = self.area[..., 0] * self.grid.mean_area * np.multiply.outer(along, around)
        return np.asarray((values.mean(axis=-1) * over_pad).sum(axis=(-2, -1)))

    def along_axes(self, vector: np.ndarray) -> np.ndarray:
        """Return a vector field (..., 2, scenes, x, y, t) along the pad's x and y, for its mean."""
        if self.grid.outline is None:
            return vector
        turned = (vector[..., 0, :, :, :, :] + 1j * vector[..., 1, :, :, :, :]) * (
            self.turn / self.area
        )
        return np.stack([turned.real, turned.imag], axis=-5)

    def on_all_nodes(self, values: np.ndarray) -> np.ndarray:
        """Values at the unknowns with zeros on the edge."""
        everywhere = np.zeros(self.gap.shape)
        everywhere[self.inner] = values
        return everywhere

    @cached_property
    def sigma(self) -> np.ndarray:
        return self.number(self.equation["sigma"])

    @cached_property
    def density(self) -> np.ndarray:
        exponent, pressure = (
            self.numbers("inverse_exponent", absent=1.0),
            1 + self.gauge_pressure_ratio,
        )
        return pressure if np.all(exponent == 1) else np.asarray(pressure**exponent)

    @cached_property
    def mass(self) -> np.ndarray:
        """Hρ, the mass of gas per area."""
        return np.asarray(self.gap * self.density)

    @cached_property
    def pressure_rate(self) -> np.ndarray:
        """∂P/∂T."""
        return self.t_derivative(self.gauge_pressure_ratio)

    @cached_property
    def slope(self) -> np.ndarray:
        """∇P."""
        return np.stack(
            [
                self.x_derivative(self.gauge_pressure_ratio),
                self.y_derivative(self.gauge_pressure_ratio),
            ]
        )

    @cached_property
    def velocity(self) -> np.ndarray:
        """Mean velocity over the gap by pressure alone, ū = −(1/σ) ``mobility`` ∇P."""
        return self.slope * (self.mobility * (-1 / self.sigma))

    @cached_property
    def mobility(self) -> np.ndarray:
        """H² W, by which a slope of pressure drives gas: W is the flow over a viscous gas'."""
        return np.asarray(flow_over_viscous(self.equation, self.mass) * self.gap**2)

    def x_derivative(self, values: np.ndarray, *, odd: bool = False) -> np.ndarray:
        """∂/∂X of a field that is even in x, or odd, wherever the axis is folded."""
        matrix = derivatives_with_edge(self.grid.x)[int(odd)] / self.lengths[0]
        return np.einsum("ab,sbyt->sayt", matrix, values, optimize=True)

    def y_derivative(self, values: np.ndarray, *, odd: bool = False) -> np.ndarray:
        matrix = derivatives_with_edge(self.grid.y)[int(odd)] / self.lengths[1]
        return np.asarray(matrix @ values)

    def slide(self, values: np.ndarray) -> np.ndarray:
        """∂/∂X along the pad's own x axis."""
        if self.grid.outline is None:
            return self.x_derivative(values)
        along, around = self.x_derivative(values), self.y_derivative(values)
        return np.asarray(self.turn.real * along - self.turn.imag * around)

    def t_derivative(self, values: np.ndarray) -> np.ndarray:
        return np.asarray(values @ self.grid.t.derivative.T)

    def divergence(self, flux: np.ndarray) -> np.ndarray:
        return self.x_derivative(flux[0], odd=True) + self.y_derivative(flux[1], odd=True)

    def carried(self, v: np.ndarray) -> np.ndarray:
        """(v·∇)v of a velocity (reynolds/terms/inertia.py)."""
        along = self.x_derivative(v[0], odd=True), self.x_derivative(v[1])
        across = self.y_derivative(v[0]), self.y_derivative(v[1], odd=True)
        bends = -self.bend.real, self.bend.imag
        square = dot(v, v) if self.grid.outline else 0.0
        parts = zip(along, across, bends, strict=True)
        return np.stack([v[0] * x + v[1] * y + bend * square for x, y, bend in parts]) / self.area


def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Product of two vector fields."""
    return np.asarray(one[0] * other[0] + one[1] * other[1])
