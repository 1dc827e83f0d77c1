"""Fields of films on the host: gap, mass, velocity by pressure, and their derivatives on one grid.

Every field has the shape (scenes, x, y, t), edge nodes included, a vector field (2, scenes, x, y,
t). Lengths in units of the pad's x side, time of 1/ω, pressure and density of ambient ones. Under
an outline vectors are along its coordinates, times |dz/dζ|, and sources of mass times J, both over
the typical (reynolds/terms/outline.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import nan
from typing import Self

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.packing import common_terms, equation_numbers_table, gap_components
from squeezefilm.reynolds.spectral import AngleAxis, Axis, FluxPoints, even_and_odd_matrices
from squeezefilm.reynolds.terms import Terms
from squeezefilm.reynolds.terms.rarefaction import flow_to_viscous_ratio


@lru_cache(maxsize=64)
def integration_weights_with_edge(axis: Axis | AngleAxis) -> np.ndarray:
    """Return the weights of the integral along an axis, those of its edge nodes included, (m,).

    A folded axis holds one edge node and the first half of the others.
    """
    if isinstance(axis, AngleAxis):
        return axis.quadrature_weights
    edge = 1 - axis.quadrature_weights.sum()  # a constant's integral is that constant
    if axis.folded:
        return np.append(edge, axis.quadrature_weights)
    return np.concatenate([[edge / 2], axis.quadrature_weights, [edge / 2]])


@lru_cache(maxsize=64)
def derivative_matrices_with_edge(axis: Axis | AngleAxis) -> tuple[np.ndarray, np.ndarray]:
    """Derivative of an even and of an odd function on all nodes, (m, m); alike if not folded.

    A folded axis holds one edge node and the first half of the others, on which a function even
    about the middle has an odd derivative and an odd one an even.
    """
    if isinstance(axis, AngleAxis):
        return axis.derivative_at_unknowns(odd=False), axis.derivative_at_unknowns(odd=True)
    even, odd = (
        even_and_odd_matrices(axis.derivative_matrix)
        if axis.folded
        else (axis.derivative_matrix,) * 2
    )
    return even, odd


@lru_cache(maxsize=64)
def flux_to_node_matrix(axis: Axis) -> np.ndarray:
    """Return the matrix to all nodes from the flux points of a velocity along the axis, (m, n)."""
    nodes = axis.all_nodes[: len(integration_weights_with_edge(axis))]
    return axis.fold_matrix(FluxPoints(axis).matrix_at(nodes), odd=True, rows=len(nodes))


@dataclass(frozen=True, eq=False)
class Fields:
    """States of films of like terms on one grid, with gap H, pressure P and density ρ.

    Attributes:
        unknowns: P − 1 and the deficits of the velocity at the unknowns, (scenes, fields, nx, ny,
            nt).
        edge_gauge_pressure: P − 1 on the film's edge, a field that is zero inside and at corners.
        terms: those that the scenes have.
        equation_number_table: the numbers of each scene's equation; they come as columns, to go
            with fields: ``number``.
        static_gap_ratio, gap: H at rest, and H.
        area, conformal_map_slope, conformal_map_log_slope: those of an outline at the nodes
            (grid.py), (x, y, 1).
    """

    scenes: Scenes
    grid: Grid
    unknowns: np.ndarray
    edge_gauge_pressure: np.ndarray
    terms: Terms
    equation_number_table: np.ndarray
    static_gap_ratio: np.ndarray
    gap: np.ndarray
    area: np.ndarray
    conformal_map_slope: np.ndarray
    conformal_map_log_slope: np.ndarray

    @classmethod
    def of(cls, scenes: Sequence[Scene], grid: Grid, unknowns: np.ndarray) -> Self:
        """States under ambient pressure on the edge."""
        scenes = Scenes.of(scenes)
        terms = common_terms(scenes)
        equation = equation_numbers_table(scenes, terms)
        nodes = (slice(len(integration_weights_with_edge(axis))) for axis in (grid.x, grid.y))
        parts = gap_components(scenes, grid).swapaxes(0, 1)[..., *nodes, None]
        rest_gap = 1 + equation_number_column(equation, "per_rise", absent=0.0) * sum(parts[2:])
        moving = equation_number_column(equation, "epsilon", absent=0.0) * parts[:2]
        sine, cosine = np.sin(grid.t.nodes), np.cos(grid.t.nodes)
        gap = rest_gap + sum(map(np.multiply, moving, (sine, cosine)))
        across = grid.x.all_nodes[: gap.shape[1]]
        along = (grid.area_ratio_at, grid.conformal_map_slope, grid.conformal_map_log_slope)
        outline = (np.asarray(at(across))[..., None] for at in along)
        ambient = np.zeros_like(gap)
        return cls(scenes, grid, unknowns, ambient, terms, equation, rest_gap, gap, *outline)

    def at(self, rows: np.ndarray | slice) -> Self:
        """The states of some of the films, which may come more than once."""
        by_scene = (
            "scenes",
            "unknowns",
            "edge_gauge_pressure",
            "equation_number_table",
            "static_gap_ratio",
            "gap",
        )
        return replace(self, **{name: getattr(self, name)[rows] for name in by_scene})

    @property
    def inner(self) -> tuple[slice, slice, slice]:
        """The unknowns' nodes among all."""
        return slice(None), self.grid.x.inner_slice, self.grid.y.inner_slice

    @cached_property
    def axis_lengths(self) -> tuple[float, float]:
        """The lengths of the axes."""
        return self.grid.axis_lengths(self.scenes[0].aspect)

    def inner_slices_across(self, k: int) -> tuple[slice, ...]:
        """The nodes of all of one axis and of the other's inside, of x for k = 0 and y for 1."""
        return tuple(slice(None) if at == 1 + k else part for at, part in enumerate(self.inner))

    @property
    def axes_with_ends(self) -> list[Axis]:
        """x and y; an outline's and a disc's angle has no ends."""
        return [axis for axis in (self.grid.x, self.grid.y) if isinstance(axis, Axis)]

    @cached_property
    def inward_normal_signs(self) -> np.ndarray:
        """±1 on the edge, of the direction along x and y into the film, else 0: (2, 1, x, y, 1).

        At corners, which no equation has, it is 0 too.
        """
        inward = np.zeros((2, 1, *self.gap.shape[1:3], 1))
        for k, axis in enumerate(self.axes_with_ends):
            at_ends = np.moveaxis(inward[k][self.inner_slices_across(k)], 1 + k, 0)
            at_ends[0] = 1.0
            if not axis.folded:
                at_ends[-1] = -1.0
        return inward

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean over film and period, shape (..., scenes)."""
        along, around = (integration_weights_with_edge(axis) for axis in (self.grid.x, self.grid.y))
        over_pad = (
            self.area[..., 0] * self.grid.inverse_mean_area * np.multiply.outer(along, around)
        )
        return np.asarray((values.mean(axis=-1) * over_pad).sum(axis=(-2, -1)))

    def equation_numbers(self, name: str, *, absent: float) -> np.ndarray:
        """A number that a term gives the scenes, a column, or what it is without the term."""
        return equation_number_column(self.equation_number_table, name, absent=absent)

    def to_pad_axes(self, vector: np.ndarray) -> np.ndarray:
        """Return a vector field (2, ..., scenes, x, y, t) along the pad's x and y, for its mean."""
        if self.grid.outline is None:
            return vector
        turned = (vector[0] + 1j * vector[1]) * (self.conformal_map_slope / self.area)
        return np.stack([turned.real, turned.imag])

    @cached_property
    def gauge_pressure_ratio(self) -> np.ndarray:
        """P − 1."""
        everywhere = self.edge_gauge_pressure.copy()
        everywhere[self.inner] = self.unknowns[:, 0]
        return everywhere

    @cached_property
    def sigma(self) -> np.ndarray:
        return self.equation_numbers("sigma", absent=nan)

    @cached_property
    def density(self) -> np.ndarray:
        exponent = self.equation_numbers("inverse_exponent", absent=1.0)
        pressure = 1 + self.gauge_pressure_ratio
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
    def gap_mean_velocity(self) -> np.ndarray:
        """Mean velocity over the gap by pressure alone, ū = −(1/σ) ``mobility`` ∇P."""
        return self.slope * (self.mobility * (-1 / self.sigma))

    @cached_property
    def velocity_on_edge(self) -> np.ndarray:
        """ū at the ends of x and of y along each: ``velocity`` less its deficit by inertia."""
        velocity = self.gap_mean_velocity.copy()
        for k, axis in enumerate(self.axes_with_ends if self.unknowns.shape[1] > 1 else ()):
            velocity[k][self.inner_slices_across(k)] -= apply_matrix_along_axis(
                k, flux_to_node_matrix(axis), self.unknowns[:, 1 + k]
            )
        return velocity

    @cached_property
    def mobility(self) -> np.ndarray:
        """H² W, by which a slope of pressure drives gas: W is the flow over a viscous gas'."""
        return np.asarray(
            flow_to_viscous_ratio(self.equation_number_table, self.mass) * self.gap**2
        )

    def x_derivative(self, values: np.ndarray, *, odd: bool = False) -> np.ndarray:
        """∂/∂X of a field that is even in x, or odd, wherever the axis is folded."""
        matrix = derivative_matrices_with_edge(self.grid.x)[int(odd)] / self.axis_lengths[0]
        return apply_matrix_along_axis(0, matrix, values)

    def y_derivative(self, values: np.ndarray, *, odd: bool = False) -> np.ndarray:
        matrix = derivative_matrices_with_edge(self.grid.y)[int(odd)] / self.axis_lengths[1]
        return apply_matrix_along_axis(1, matrix, values)

    def pad_x_derivative(self, values: np.ndarray) -> np.ndarray:
        """∂/∂X along the pad's own x axis."""
        if self.grid.outline is None:
            return self.x_derivative(values)
        along, around = self.x_derivative(values), self.y_derivative(values)
        return np.asarray(
            self.conformal_map_slope.real * along - self.conformal_map_slope.imag * around
        )

    def t_derivative(self, values: np.ndarray) -> np.ndarray:
        return np.asarray(values @ self.grid.t.derivative_matrix.T)

    def divergence(self, flux: np.ndarray) -> np.ndarray:
        return self.x_derivative(flux[0], odd=True) + self.y_derivative(flux[1], odd=True)

    def convective_acceleration(self, v: np.ndarray) -> np.ndarray:
        """(v·∇)v of a velocity (reynolds/terms/inertia.py)."""
        along = self.x_derivative(v[0], odd=True), self.x_derivative(v[1])
        across = self.y_derivative(v[0]), self.y_derivative(v[1], odd=True)
        bends = -self.conformal_map_log_slope.real, self.conformal_map_log_slope.imag
        square = dot(v, v) if self.grid.outline else 0.0
        parts = zip(along, across, bends, strict=True)
        return np.stack([v[0] * x + v[1] * y + bend * square for x, y, bend in parts]) / self.area


def equation_number_column(equation: np.ndarray, name: str, *, absent: float) -> np.ndarray:
    """Return a number of scenes' equation, (scenes, 1, 1, 1), or what it is where there is none."""
    known = name in (equation.dtype.names or ())
    values = equation[name] if known else np.full(len(equation), absent)
    return np.asarray(values)[:, None, None, None]


def apply_matrix_along_axis(k: int, matrix: np.ndarray, field: np.ndarray) -> np.ndarray:
    """Return a matrix times a field along x for k = 0, along y for 1."""
    columns = field if k else field.reshape(*field.shape[:2], -1)
    return np.asarray(matrix @ columns).reshape(*field.shape[: 1 + k], -1, *field.shape[2 + k :])


def fold_even_columns(matrix: np.ndarray, axis: Axis) -> np.ndarray:
    """Return a matrix from an even function on all nodes as one from those of the first half."""
    half = matrix.shape[1] // 2
    return matrix[:, :half] + matrix[:, : half - 1 : -1] if axis.folded else matrix


def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Product of two vector fields."""
    return np.asarray(one[0] * other[0] + one[1] * other[1])
