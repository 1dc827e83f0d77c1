"""The physics limits of a study as polynomials of the four factors, to go with a fitted model.

A model that uses them can then be evaluated from its file alone, anywhere in the box of the
factors. A limit over ε² is smooth, so few Chebyshev points per factor are enough.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import CARTESIAN, form_of
from squeezefilm.models.force_model import COLUMNS, Factors

Array = NDArray[np.float64]

AXES = ("h0_m", "epsilon_square")
"""And the two of the position."""
POINTS = {"h0_m": 3, "epsilon_square": 11, "phi_r_m": 7, "phi_deg": 6, "x_m": 8, "y_m": 8}
"""Of directions, for 45°: the force over more of them bends more often. Of x and y, on one side."""
POINTS_OF_SCALES = POINTS | {"h0_m": 6}
"""Inertia grows like the square of the gap, and a tilt or bulge counts less in a wider one."""
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


def nodes(
    ranges: Mapping[str, tuple[float, float]], counts: Mapping[str, int] = POINTS
) -> tuple[dict[str, Array], tuple[int, ...]]:
    """The Chebyshev points of the box, each axis as an array over all of them, and the shape.

    An axis without extent has one point.
    """
    lines = []
    for axis, (low, high) in ranges.items():
        points = counts[axis] if high > low else 1
        if axis == "phi_deg" and high - low > 45:
            points = round(points * ((high - low) / 45) ** (2 / 3))
        if axis in CARTESIAN and low < 0:
            points = round(1.5 * points)
        lines.append((low + high) / 2 + (high - low) / 2 * chebyshev.chebpts1(points))
    grid = np.meshgrid(*lines, indexing="ij")
    return dict(zip(ranges, (each.ravel() for each in grid), strict=True)), grid[0].shape


def coefficients_of(values: Array) -> Array:
    """Chebyshev coefficients of values at the nodes, shape of the grid."""
    for axis, points in enumerate(values.shape):
        at_nodes = chebyshev.chebvander(chebyshev.chebpts1(points), points - 1)
        moved = np.tensordot(np.linalg.inv(at_nodes), values, axes=(1, axis))
        values = np.moveaxis(moved, 0, axis)
    return values
