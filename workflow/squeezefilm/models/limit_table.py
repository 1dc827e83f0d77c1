"""The physics limits of a study as polynomials of the four factors, to go with a fitted model.

A model that uses them can then be evaluated from its file alone, anywhere in the box of the
factors. A limit over ε² is smooth; how many Chebyshev points each factor needs is measured on a few
lines through the box, for over the position it bends as often as the profile.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import form_of
from squeezefilm.models.force_model import COLUMNS, Factors

Array = NDArray[np.float64]

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


@dataclass(frozen=True, eq=False)
class LimitTable:
    """Chebyshev coefficients of the limits over ε², in newtons, by their columns.

    ranges: of each of AXES and of the position; coefficients: of shape (points of each axis);
    sigma_h0_square: squeeze number times h0², in m²; error: largest relative error of the table at
    its check points.
    """

    ranges: Mapping[str, tuple[float, float]]
    coefficients: Mapping[str, Array]
    sigma_h0_square: float
    error: float

    def complete(self, factors: Factors) -> Factors:
        """The factors with the limits' columns; NaN outside the table."""
        columns = {name: self._interpolate(name, factors) for name in self.coefficients}
        sigma = self.sigma_h0_square / factors.h0_m**2
        own = {name: factors.column(name) for name in ("h0_m", "hv_m", *factors.position)}
        return Factors.of(**own, **columns, sigma=sigma)

    def _interpolate(self, name: str, factors: Factors) -> Array:
        places, inside = self.places(factors)
        values = np.empty(len(factors))
        for start in range(0, len(factors), BATCH):
            some = slice(start, start + BATCH)
            a, b, c, d = (
                chebyshev.chebvander(places[axis][some], points - 1)
                for axis, points in zip(self.ranges, self.coefficients[name].shape, strict=True)
            )
            part = np.einsum("abcd,nd->nabc", self.coefficients[name], d)
            part = np.einsum("nabc,nc->nab", part, c)
            values[some] = np.einsum("nab,nb,na->n", part, b, a)
        return np.where(inside, values * factors.epsilon**2, np.nan)

    def places(self, factors: Factors) -> tuple[dict[str, Array], Array]:
        """Where the points lie on each axis, in [-1, 1], and which lie inside the table."""
        values = {"h0_m": factors.h0_m, "epsilon_square": factors.epsilon**2}
        values |= {name: factors.column(name) for name in form_of(self.ranges)}
        if "phi_deg" in values:  # every direction is the same at the centre
            at_centre = factors.phi_r_m <= SLACK * max(self.ranges["phi_r_m"][1], 1e-300)
            values["phi_deg"] = np.where(at_centre, self.ranges["phi_deg"][0], factors.phi_deg)
        inside = np.ones(len(factors), dtype=bool)
        places = {}
        for axis, (low, high) in self.ranges.items():
            half = (high - low) / 2
            middle = (high + low) / 2
            slack = SLACK * max(abs(low), abs(high))
            inside &= (values[axis] >= low - slack) & (values[axis] <= high + slack)
            place = (values[axis] - middle) / half if half else np.zeros(len(factors))
            places[axis] = np.clip(place, -1.0, 1.0)
        return places, inside

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and lists, ready for JSON."""
        return {
            "ranges": {axis: list(limits) for axis, limits in self.ranges.items()},
            "shape": list(next(iter(self.coefficients.values())).shape),
            "coefficients": {
                name: each.ravel().tolist() for name, each in self.coefficients.items()
            },
            "sigma_h0_square_m2": self.sigma_h0_square,
            "largest_relative_error": self.error,
        }

    @classmethod
    def from_dict(cls, plain: Any, *, place: str) -> LimitTable:
        """The table written by to_dict; raises InputError, naming the place, for anything else."""
        try:
            ranges = {
                axis: (float(low), float(high))
                for axis in (*AXES, *form_of(plain["ranges"]))
                for low, high in [plain["ranges"][axis]]
            }
            shape = tuple(int(count) for count in plain["shape"])
            coefficients = {
                str(name): np.array(values, dtype=float).reshape(shape)
                for name, values in plain["coefficients"].items()
            }
            table = cls(
                ranges=ranges,
                coefficients=coefficients,
                sigma_h0_square=float(plain["sigma_h0_square_m2"]),
                error=float(plain["largest_relative_error"]),
            )
        except (KeyError, TypeError, ValueError, AttributeError):
            raise InputError(f"{place}: not a table of limits as `limit-table` writes it") from None
        finite = all(np.all(np.isfinite(each)) for each in coefficients.values())
        known = set(coefficients) <= set(COLUMNS.values())
        if len(shape) != len(ranges) or not finite or not known:
            raise InputError(f"{place}: not a table of limits as `limit-table` writes it")
        return table


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
        tail = tails_of[axis]
        return float(tail[counts[axis]]) if counts[axis] < len(tail) else 0.0

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
