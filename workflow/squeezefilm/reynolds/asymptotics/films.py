"""A batch of films on one grid: operators, and the features that error estimates need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from squeezefilm.reynolds.asymptotics.edge_layer import quadrature_weights_with_ends
from squeezefilm.reynolds.spectral import Axis, cached_axis

# The error estimates' constants.
(
    EDGE_SLOPE_ERROR_FACTOR,
    INNER_CURVATURE_ERROR_FACTOR,
    CORNER_ERROR_FACTOR,
    MEETING_LAYERS_ERROR_FACTOR,
) = 4.5, 3.0, 0.9, 4.5
STIFF_FILM_ERROR_FACTOR, FREE_FLOW_ERROR_FACTOR, FREE_FLOW_SIGMA = 0.8, 6.0, 6.0
STREAMING_ERROR_FACTOR = 1.5
STATIC_GAP_ERROR_FACTOR = 0.02
SLIP_ERROR_FACTOR = 0.5
INERTIA_SLOPE_ERROR_FACTOR, INERTIA_CORNER_ERROR_FACTOR, INERTIA_COMPOSITE_ERROR_FACTOR = (
    1.8,
    1.2,
    2.0,
)
# Forces on two grids can agree by cancellation where the densities do not.
MIN_ERROR_PER_DENSITY_CHANGE = 0.1

# Of the rounds that solve for the core with inertia, or under a gap that is shaped at rest.
FIXED_POINT_PRECISION, MAX_FIXED_POINT_ROUNDS = 1e-11, 100

FloatOrArray = float | np.ndarray


def expansion_axis(points: int) -> Axis:
    """The axis of an expansion's grid: ``points`` unknowns, odd: every other node makes a grid."""
    if points % 2 == 0 or points < 5:
        raise ValueError(f"{points} points: the grid of an expansion has an odd number, at least 5")
    return cached_axis(points, False)


@dataclass(frozen=True)
class Films:
    """A batch on one grid: its operators, and the features that the error estimates need.

    Fields have shape (B, nx + 2, ny + 2); values on the edge (B, 2 (nx + ny + 4)), side after side:
    x = 0, x = 1, y = 0, y = aspect. Lengths are in units of the side along x. Two quadrature
    components have s₁ + i s₂ for s. For a non-uniform gap at rest s is over that gap, which is
    ``static_gap``, in units of h0; None for a uniform one.
    """

    epsilon: np.ndarray
    sigma: np.ndarray
    s: np.ndarray
    aspect: np.ndarray
    slip: np.ndarray
    reynolds: np.ndarray
    static_gap: np.ndarray | None = None

    @property
    def x_axis(self) -> Axis:
        return cached_axis(self.s.shape[1] - 2, False)

    @property
    def y_axis(self) -> Axis:
        return cached_axis(self.s.shape[2] - 2, False)

    @property
    def coarser_films(self) -> Films:
        """The same films on every other node."""
        rest_gap = None if self.static_gap is None else self.static_gap[:, ::2, ::2]
        return replace(self, s=self.s[:, ::2, ::2], static_gap=rest_gap)

    def select_films(self, which: np.ndarray) -> Films:
        """Some of the films, by a mask (B,); those with inertia have an even gap."""
        own = (self.epsilon, self.sigma, self.s, self.aspect, self.slip, self.reynolds)
        return Films(*(values[which] for values in own))

    def pad_mean(self, field: np.ndarray) -> np.ndarray:
        """Mean over the pad, shape (B,)."""
        return (field @ quadrature_weights_with_ends(self.y_axis)) @ quadrature_weights_with_ends(
            self.x_axis
        )

    def gradient(self, field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives along x and y."""
        along_y = field @ self.y_axis.derivative_matrix.T / broadcast_over_field(self.aspect)
        return self.x_axis.derivative_matrix @ field, along_y

    def divergence(self, along_x: np.ndarray, along_y: np.ndarray) -> np.ndarray:
        across = along_y @ self.y_axis.derivative_matrix.T / broadcast_over_field(self.aspect)
        return self.x_axis.derivative_matrix @ along_x + across

    def laplacian(self, field: np.ndarray) -> np.ndarray:
        along_y = (
            field @ _second_derivative_matrix(self.y_axis.unknown_count).T
        ) / broadcast_over_field(self.aspect) ** 2
        return _second_derivative_matrix(self.x_axis.unknown_count) @ field + along_y

    def solve_helmholtz(self, source: np.ndarray, *, shift: np.ndarray | float = 0.0) -> np.ndarray:
        """The u with ∇²u − shift u = source that is zero on the edge; by fast diagonalisation."""
        values_x, vectors_x, inverse_x = self.x_axis.eigenmodes
        values_y, vectors_y, inverse_y = self.y_axis.eigenmodes
        divisor = values_x[:, None] + values_y / broadcast_over_field(self.aspect) ** 2 - shift
        modes = inverse_x @ source[:, 1:-1, 1:-1] @ inverse_y.T / divisor
        u = np.zeros(source.shape, dtype=modes.dtype)
        u[:, 1:-1, 1:-1] = vectors_x @ modes @ vectors_y.T
        return u

    def diffusion_of_field(self, field: np.ndarray) -> np.ndarray:
        """∇·(G³∇field) with the gap at rest G."""
        if self.static_gap is None:
            return self.laplacian(field)
        along_x, along_y = self.gradient(field)
        return self.divergence(self.static_gap**3 * along_x, self.static_gap**3 * along_y)

    def solve_diffusion(self, source: np.ndarray) -> np.ndarray:
        """The u with ∇·(G³∇u) = source that is zero on the edge; NaN where none is found.

        With v = G^(3/2) u that is Δv − q v = source/G^(3/2), q = Δ(G^(3/2))/G^(3/2) (Liouville),
        where q is nearly the same everywhere: in rounds by Δ less its middle.
        """
        if self.static_gap is None:
            return self.solve_helmholtz(source)
        half = self.static_gap**1.5
        bend = self.laplacian(half) / half
        middle = broadcast_over_field((bend.max(axis=(1, 2)) + bend.min(axis=(1, 2))) / 2)

        def next_iterate(v: np.ndarray) -> np.ndarray:
            return self.solve_helmholtz(source / half + (bend - middle) * v, shift=middle)

        return find_fixed_point(next_iterate, np.zeros_like(half)) / half

    def edge_values(self, field: np.ndarray) -> np.ndarray:
        sides = [field[:, 0], field[:, -1], field[:, :, 0], field[:, :, -1]]
        return np.concatenate(sides, axis=1)

    def blend_edge_values(self, values: np.ndarray) -> np.ndarray:
        """A smooth field with these values on the edge, blended between opposite sides (Coons)."""
        nx, ny = self.x_axis.unknown_count + 2, self.y_axis.unknown_count + 2
        left, right, low, high = np.split(values, [ny, 2 * ny, 2 * ny + nx], axis=1)
        x, y = self.x_axis.all_nodes[:, None], self.y_axis.all_nodes
        ends = [(1 - x, left[:, None]), (x, right[:, None])]
        corners = sum(
            blend * (side[..., :1] * (1 - y) + side[..., -1:] * y) for blend, side in ends
        )
        between_x = (1 - x) * left[:, None] + x * right[:, None]
        between_y = (1 - y) * low[:, :, None] + y * high[:, :, None]
        field: np.ndarray = between_x + between_y - corners
        return field

    def inward_normal_derivative(self, field: np.ndarray) -> np.ndarray:
        """Derivative along the inward normal, on the edge."""
        ends_x, ends_y = (
            self.x_axis.derivative_matrix[[0, -1]],
            self.y_axis.derivative_matrix[[0, -1]],
        )
        across_x = ends_x @ field
        across_y = field @ ends_y.T / broadcast_over_field(self.aspect)
        sides = [across_x[:, 0], -across_x[:, 1], across_y[:, :, 0], -across_y[:, :, 1]]
        return np.concatenate(sides, axis=1)

    def edge_integral(self, values: np.ndarray) -> np.ndarray:
        """Integral along the edge over the pad's area, shape (B,)."""
        sides = np.split(values, [2 * (self.y_axis.unknown_count + 2)], axis=1)
        weights = (
            np.tile(quadrature_weights_with_ends(line), 2) for line in (self.y_axis, self.x_axis)
        )
        along_y, along_x = (
            side @ weights_of_side for side, weights_of_side in zip(sides, weights, strict=True)
        )
        integral: np.ndarray = along_y + along_x / self.aspect
        return integral

    @cached_property
    def static_gap_on_edge(self) -> np.ndarray | float:
        """The static gap over h0 on the film edge."""
        return 1.0 if self.static_gap is None else self.edge_values(self.static_gap)

    @cached_property
    def profile_squared(self) -> np.ndarray:
        """|s|², the profile's squared magnitude."""
        return np.square(np.abs(self.s))

    @cached_property
    def edge_profile(self) -> np.ndarray:
        """The profile on the edge."""
        return self.edge_values(self.s)

    @cached_property
    def edge_normal_slope(self) -> np.ndarray:
        """The profile's inward derivative on the edge."""
        return self.inward_normal_derivative(self.s)

    @cached_property
    def profile_laplacian(self) -> np.ndarray:
        """∇²s."""
        return self.laplacian(self.s)

    @cached_property
    def narrowing_factor(self) -> np.ndarray:
        """1/(1 − ε² max s²): grows as the narrowest gap closes."""
        return 1 / (1 - (self.epsilon * np.abs(self.s).max(axis=(1, 2))) ** 2)

    @property
    def layer_squeeze_number(self) -> np.ndarray:
        """Squeeze number that sets the layer's thickness: slip makes gas flow more freely.

        Where the gap at rest is not even, that of its widest place.
        """
        widest = 1.0 if self.static_gap is None else self.static_gap.max(axis=(1, 2))
        return self.sigma / ((1 + self.slip) * widest**2)

    @property
    def decay_squeeze_number(self) -> np.ndarray:
        """Squeeze number of a layer that decays as fast: with inertia, waves reach farther."""
        ratio = self.reynolds / 10
        return self.layer_squeeze_number * (np.hypot(1, ratio) - ratio)

    @property
    def slip_remainder_fraction(self) -> np.ndarray:
        """Relative change of the layer by slip beyond the change of its thickness, at most."""
        return SLIP_ERROR_FACTOR * self.slip

    @property
    def corner_remainder(self) -> np.ndarray:
        """Error from the corners, where two layers meet: of order ε⁴/σ."""
        corners = self.profile_squared[:, [0, 0, -1, -1], [0, -1, 0, -1]].sum(axis=1)
        return (
            CORNER_ERROR_FACTOR
            * self.epsilon**4
            * self.narrowing_factor
            * corners
            / (self.layer_squeeze_number * self.aspect)
        )

    @property
    def layer_remainder(self) -> np.ndarray:
        """Error of the edge layer's expansion: slopes, curvature of s, corners, meeting layers."""
        sigma = self.layer_squeeze_number
        curvature = self.pad_mean(np.abs(self.profile_laplacian) ** 2)
        meeting = np.exp(-np.sqrt(self.decay_squeeze_number / 2) * np.minimum(1, self.aspect))
        remainder = self.corner_remainder + np.sqrt(self.narrowing_factor) * self.inertia_remainder
        return (
            remainder
            + self.streaming_remainder
            + self.static_gap_remainder
            + self.epsilon**2
            * (
                EDGE_SLOPE_ERROR_FACTOR
                * np.sqrt(self.narrowing_factor)
                * self.edge_unevenness_integral
                / sigma**1.5
                + INNER_CURVATURE_ERROR_FACTOR
                * np.sqrt(self.narrowing_factor)
                * curvature
                / sigma**2
                + MEETING_LAYERS_ERROR_FACTOR
                * self.edge_integral(np.abs(self.edge_profile) ** 2)
                * meeting
                / np.sqrt(sigma)
            )
        )

    @property
    def streaming_remainder(self) -> np.ndarray | float:
        """Error of the edge layer's expansion by a second quadrature component: of order ε²/σ."""
        if not np.iscomplexobj(self.s):
            return 0.0
        uneven = self.pad_mean(self.profile_unevenness)
        root = np.sqrt(self.narrowing_factor)
        return STREAMING_ERROR_FACTOR * self.epsilon**2 * root * uneven / self.layer_squeeze_number

    @property
    def static_gap_remainder(self) -> np.ndarray | float:
        """Error of the edge layer's expansion by a gap that is shaped at rest: of order ε²/σ."""
        if self.static_gap is None:
            return 0.0
        along_x, along_y = self.gradient(self.static_gap)
        steep = self.edge_values((along_x**2 + along_y**2) / self.static_gap**2)
        bent = self.edge_values(np.abs(self.laplacian(self.static_gap)) / self.static_gap)
        uneven = self.edge_integral((steep + bent) * np.abs(self.edge_profile) ** 2)
        root = np.sqrt(self.narrowing_factor)
        return STATIC_GAP_ERROR_FACTOR * self.epsilon**2 * root * uneven / self.layer_squeeze_number

    @property
    def inertia_remainder(self) -> np.ndarray | float:
        """Error of the edge layer's expansion by inertia: of order ε²/σ, at corners ε² ln σ/σ."""
        if not self.reynolds.any():
            return 0.0
        corners = self.profile_squared[:, [0, 0, -1, -1], [0, -1, 0, -1]].sum(axis=1) / self.aspect
        spread = np.maximum(np.log(self.sigma) - 2.2, 0.5)
        uneven = (
            INERTIA_SLOPE_ERROR_FACTOR * self.edge_unevenness_integral
            + INERTIA_CORNER_ERROR_FACTOR * spread * corners
        )
        return self.epsilon**2 * uneven * self.reynolds / 10 / self.decay_squeeze_number

    @cached_property
    def edge_unevenness_integral(self) -> np.ndarray:
        """Integral of the unevenness along the edge, over the area."""
        return self.edge_integral(self.edge_values(self.profile_unevenness))

    @cached_property
    def profile_unevenness(self) -> np.ndarray:
        """|∇s|² + |s ∇²s|."""
        along_x, along_y = self.gradient(self.s)
        return np.abs(along_x) ** 2 + np.abs(along_y) ** 2 + np.abs(self.s * self.profile_laplacian)

    @property
    def second_order_remainder(self) -> np.ndarray:
        """Relative error of the second-order mean: of order ε².

        From 0.4 ε² where the film is stiff to 21/4 ε² where the gas flows freely (σ → 0, where the
        mean goes like ⟨Ḣ²/H⁶⟩ = ε²/2 (1 + 21 ε²/4 + …) and with ``narrowing_factor`` to the power
        9/2). For two quadrature components twice that.
        """
        effective = self.decay_squeeze_number / (1 + self.aspect**-2.0)
        free = 1 / (1 + (effective / FREE_FLOW_SIGMA) ** 2)
        phases = 2 if np.iscomplexobj(self.s) else 1
        return (
            phases
            * self.epsilon**2
            * (STIFF_FILM_ERROR_FACTOR + FREE_FLOW_ERROR_FACTOR * free)
            * self.narrowing_factor ** (1 + 3.5 * free)
        )


def films_of(
    epsilon: np.ndarray,
    sigma: np.ndarray,
    amplitude: np.ndarray,
    *,
    aspect: FloatOrArray = 1.0,
    slip: FloatOrArray = 0.0,
    reynolds: FloatOrArray = 0.0,
    rest_gap: np.ndarray | None = None,
) -> Films:
    """Films of profiles over h0, and of gaps at rest likewise if they are not even.

    Args:
        epsilon, sigma: excursion ratio and squeeze number, shape (B,).
        amplitude: profile s, or s₁ + i s₂ of two quadrature components, on the nodes
            ``expansion_axis(n).all_nodes`` along x and y, ends included, shape (B, nx + 2, ny + 2);
            nx and ny odd, at least 5 (``composite.expansion_nodes_per_axis``). With inertia in one
            phase alone.
        aspect: pad's length along y over that along x, a number or shape (B,).
        slip: first-order slip 6 Kn at the mean gap, a number or shape (B,); 0 without slip.
        reynolds: modified Reynolds number ρ ω h0²/μ, a number or shape (B,); 0 without inertia.
        rest_gap: over h0, on the same nodes where it is not even, without slip and inertia;
            for the high-squeeze limit and the edge layer alone.
    """
    for points in amplitude.shape[1:]:
        expansion_axis(points - 2)
    given = (epsilon, sigma, aspect, slip, reynolds)
    epsilon, sigma, aspect, slip, reynolds = np.broadcast_arrays(
        *(np.asarray(number, dtype=float) for number in given)
    )
    local = amplitude if rest_gap is None else amplitude / rest_gap
    return Films(epsilon, sigma, local, aspect, slip, reynolds, rest_gap)


def grid_error(
    films: Films, fine: np.ndarray, coarse: np.ndarray, *, layer_change: np.ndarray | float = 0.0
) -> np.ndarray:
    """Difference of the mean from that on every second node, or a part of the density's.

    Args:
        fine, coarse: densities whose means over the pad are compared, on the two grids.
        layer_change: change of what is not in the densities.
    """
    half = films.coarser_films
    change = films.pad_mean(fine) - half.pad_mean(coarse) + layer_change
    return np.maximum(
        np.abs(change),
        MIN_ERROR_PER_DENSITY_CHANGE * half.pad_mean(np.abs(fine[:, ::2, ::2] - coarse)),
    )


def find_fixed_point(step: Callable[[np.ndarray], np.ndarray], start: np.ndarray) -> np.ndarray:
    """Return the fixed point of ``step``; NaN for films whose iteration does not converge."""
    field = start
    for _ in range(MAX_FIXED_POINT_ROUNDS):
        last, field = field, step(field)
        change = np.abs(field - last).max(axis=(1, 2))
        if not np.any(change > FIXED_POINT_PRECISION * np.abs(field).max(axis=(1, 2))):
            break
    settled = change <= 1e3 * FIXED_POINT_PRECISION * np.abs(field).max(axis=(1, 2))
    return np.where(broadcast_over_field(settled), field, np.nan)


def broadcast_over_field(values: np.ndarray) -> np.ndarray:
    return values[:, None, None]


@lru_cache(maxsize=64)
def _second_derivative_matrix(points: int) -> np.ndarray:
    first = cached_axis(points, False).derivative_matrix
    return first @ first
