"""The asymptotic forces of a study as polynomials of the four factors, to go with a fitted model.

A model that uses them can then be evaluated from its file alone, anywhere in the box of the
factors. A limit over ε² is smooth; how many Chebyshev points each factor needs is measured on a few
lines through the box, for over the position it bends as often as the profile.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from math import prod
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev
from pydantic import BaseModel, ConfigDict, FiniteFloat, model_validator

from squeezefilm.models.data import Array, Factors
from squeezefilm.solution import form_of

AXES = ("h0_m", "epsilon_square")
"""And the two of the position."""
LINE_POINTS = 65
"""Chebyshev points of a line on which the decay of coefficients is measured."""
LEAST_POINTS, MOST_NODES = 3, 15_000
"""Of an axis; of a table, whose file grows with them."""
LARGEST_EPSILON_SQUARE = 0.5
"""Amplitudes up to 0.7 of the gap: beyond a study's, since a wanted force may lie there."""
SLACK = 1e-9
BATCH = 1024


class LimitTable(BaseModel):
    """Chebyshev coefficients of the limits over ε², in newtons, by their columns.

    ranges: of each of AXES and of the position; coefficients: flat, of that shape (points of each
    axis); sigma_h0_square_m2: squeeze number times h0²; largest_relative_error: of the table at
    its check points.
    """

    model_config = ConfigDict(frozen=True)

    ranges: dict[str, tuple[float, float]]
    shape: tuple[int, int, int, int]
    coefficients: dict[Literal["limit_n", "fast_limit_n"], list[FiniteFloat]]
    sigma_h0_square_m2: float
    largest_relative_error: float

    @model_validator(mode="after")
    def _consistent(self) -> LimitTable:
        axes = (*AXES, *form_of(self.ranges))
        if set(self.ranges) != set(axes):
            raise ValueError(f"ranges must be of {', '.join(axes)}")
        if any(len(flat) != prod(self.shape) for flat in self.coefficients.values()):
            raise ValueError(f"{prod(self.shape)} coefficients are needed for the shape")
        return self

    @cached_property
    def axes(self) -> dict[str, tuple[float, float]]:
        """The ranges in the order of the shape; a file has them in any."""
        return {axis: self.ranges[axis] for axis in (*AXES, *form_of(self.ranges))}

    @cached_property
    def tables(self) -> dict[str, Array]:
        """The coefficients in the table's shape."""
        return {
            name: np.reshape(flat, self.shape).astype(float)
            for name, flat in self.coefficients.items()
        }

    def complete(self, factors: Factors) -> Factors:
        """The factors with the limits' columns; NaN outside the table."""
        values = {"h0_m": factors.h0_m, "epsilon_square": factors.epsilon**2}
        values |= {name: factors.column(name) for name in form_of(self.ranges)}
        if "phi_deg" in values:  # every direction is the same at the centre
            at_centre = factors.phi_r_m <= SLACK * max(self.ranges["phi_r_m"][1], 1e-300)
            values["phi_deg"] = np.where(at_centre, self.ranges["phi_deg"][0], factors.phi_deg)
        low, high = np.array(list(self.axes.values())).T[:, :, None]
        at, half = np.array([values[axis] for axis in self.axes]), (high - low) / 2
        slack = SLACK * np.maximum(np.abs(low), np.abs(high))
        inside = np.all((at >= low - slack) & (at <= high + slack), axis=0)
        places = np.clip((at - (high + low) / 2) / np.where(half > 0, half, np.inf), -1.0, 1.0)
        columns = {
            name: np.where(inside, factors.epsilon**2 * _sums(table, places), np.nan)
            for name, table in self.tables.items()
        }
        columns["sigma"] = self.sigma_h0_square_m2 / factors.h0_m**2
        return replace(factors, columns=columns)


def _sums(table: Array, places: Array) -> Array:
    """Sums of Chebyshev polynomials with a table of coefficients, at places (4, n) in [-1, 1]."""
    parts = []
    for some in np.array_split(places, range(BATCH, places.shape[1], BATCH), axis=1):
        part = table[None]
        for place, points in zip(some[::-1], table.shape[::-1], strict=True):
            part = np.einsum("n...d,nd->n...", part, chebyshev.chebvander(place, points - 1))
        parts.append(part)
    return np.concatenate(parts)


def tails(values: Array) -> Array:
    """Error of an interpolation with fewer Chebyshev points, relative to the mean value.

    Args:
        values: at the Chebyshev points of some lines along one axis, shape (lines, n).

    Returns the largest over the lines of Σ |c_k|, k ≥ m, for m = 0 … n − 1, shape (n,).
    """
    sizes = np.abs(_transformed(values, axis=1)) / np.abs(values).mean(axis=1, keepdims=True)
    return np.flip(np.cumsum(np.flip(sizes, axis=1), axis=1), axis=1).max(axis=0)


def counts_for(tails_of: Mapping[str, Array], *, tolerance: float) -> dict[str, int]:
    """Points of each axis: one more where the tail is longest, until all hold the tolerance.

    Or until there are MOST_NODES, or as many points as were measured.
    """
    counts = {axis: min(LEAST_POINTS, len(tail)) for axis, tail in tails_of.items()}

    def left(axis: str) -> float:
        return float(np.append(tails_of[axis], 0.0)[counts[axis]])

    while left(widest := max(counts, key=left)) > tolerance:
        if prod(counts.values()) // counts[widest] * (counts[widest] + 1) > MOST_NODES:
            break
        counts[widest] += 1
    return counts


def nodes(
    ranges: Mapping[str, tuple[float, float]], counts: Mapping[str, int]
) -> tuple[dict[str, Array], tuple[int, ...]]:
    """The Chebyshev points of the box, each axis as an array over all of them, and the shape."""
    lines = [between(limits, chebyshev.chebpts1(counts[axis])) for axis, limits in ranges.items()]
    grid = np.meshgrid(*lines, indexing="ij")
    return dict(zip(ranges, (each.ravel() for each in grid), strict=True)), grid[0].shape


def between(limits: tuple[float, float], place: Array) -> Array:
    """Values of a factor at places in [-1, 1] between its limits."""
    low, high = limits
    return (low + high) / 2 + (high - low) / 2 * place


def coefficients_of(values: Array) -> Array:
    """Chebyshev coefficients of values at the nodes, shape of the grid."""
    for axis in range(values.ndim):
        values = _transformed(values, axis=axis)
    return values


def _transformed(values: Array, *, axis: int) -> Array:
    points = values.shape[axis]
    at_nodes = chebyshev.chebvander(chebyshev.chebpts1(points), points - 1)
    moved = np.tensordot(np.linalg.inv(at_nodes), values, axes=(1, axis))
    return np.moveaxis(moved, 0, axis)
