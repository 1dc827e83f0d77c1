"""The asymptotic forces of a study as polynomials of the four factors, to go with a fitted model.

A model that uses them can then be evaluated from its file alone, anywhere in the box of the
factors. studies/tasks/physics_limits.py makes such a table.
"""

from __future__ import annotations

from functools import cached_property
from math import prod
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, FiniteFloat, model_validator

from squeezefilm.columns import COLUMNS
from squeezefilm.film.positions import find_position_columns
from squeezefilm.models.data import RANGE_TOLERANCE, Array, Factors

AXIS_NAMES = ("h0_m", "epsilon_square")
"""And the two of the position."""
POINTS_PER_BATCH = 1024


class LimitTable(BaseModel):
    """Chebyshev coefficients of the limits over ε², in newtons, by their columns.

    ranges: of each of AXIS_NAMES and of the position; coefficients: flat, of that shape (points of
    each axis); sigma_h0_square_m2: squeeze number times h0²; largest_relative_error: of the table
    at its check points.
    """

    model_config = ConfigDict(frozen=True)

    ranges: dict[str, tuple[float, float]]
    shape: tuple[int, int, int, int]
    coefficients: dict[Literal["limit_n", "fast_limit_n"], list[FiniteFloat]]
    sigma_h0_square_m2: float
    largest_relative_error: float

    @model_validator(mode="after")
    def _check_consistent(self) -> LimitTable:
        axes = (*AXIS_NAMES, *find_position_columns(self.ranges))
        if set(self.ranges) != set(axes):
            raise ValueError(f"ranges must be of {', '.join(axes)}")
        if any(len(flat) != prod(self.shape) for flat in self.coefficients.values()):
            raise ValueError(f"{prod(self.shape)} coefficients are needed for the shape")
        return self

    @cached_property
    def axis_levels(self) -> dict[str, tuple[float, float]]:
        """The ranges in the order of the shape; a file has them in any."""
        return {
            axis: self.ranges[axis] for axis in (*AXIS_NAMES, *find_position_columns(self.ranges))
        }

    @cached_property
    def tables(self) -> dict[str, Array]:
        """The coefficients in the table's shape."""
        return {
            name: np.reshape(flat, self.shape).astype(float)
            for name, flat in self.coefficients.items()
        }

    def outside_masks(self, factors: Factors) -> dict[str, NDArray[np.bool_]]:
        """Return masks of the points beyond the table, shape (n,), by its axes."""
        values = {**factors.columns, "epsilon_square": factors.epsilon**2}
        return Factors(values).outside_masks(self.axis_levels)

    def limits_text(self, axis: str) -> str:
        """Return the range of one of the table's axes, in words."""
        low, high = self.ranges[axis]
        if axis == "epsilon_square":
            return f"hv/h0 = {high**0.5:.3g}"
        column = COLUMNS[axis]
        ends = " and ".join(f"{column.in_shown_unit(end):.4g}" for end in sorted({low, high}))
        return f"{column.text_symbol} = {ends} {column.shown_unit}"

    def with_asymptotic_forces(self, factors: Factors) -> Factors:
        """The factors with the limits' columns; NaN outside the table."""
        values = {**factors.columns, "epsilon_square": factors.epsilon**2}
        inside = ~np.any(list(self.outside_masks(factors).values()), axis=0)
        if "phi_deg" in self.axis_levels:  # every direction is the same at the centre
            at_centre = factors.phi_r_m <= RANGE_TOLERANCE * self.axis_levels["phi_r_m"][1]
            values["phi_deg"] = np.where(at_centre, self.axis_levels["phi_deg"][0], factors.phi_deg)
        low, high = np.array(list(self.axis_levels.values())).T[:, :, None]
        at, half = np.array([values[axis] for axis in self.axis_levels]), (high - low) / 2
        table_coordinates = np.clip(
            (at - (high + low) / 2) / np.where(half > 0, half, np.inf), -1.0, 1.0
        )
        columns = {
            name: np.where(
                inside, factors.epsilon**2 * _chebyshev_sums(table, table_coordinates), np.nan
            )
            for name, table in self.tables.items()
        }
        columns["sigma"] = self.sigma_h0_square_m2 / factors.h0_m**2
        return Factors({**factors.columns, **columns}, factors.position_columns)


def _chebyshev_sums(table: Array, table_coordinates: Array) -> Array:
    """Sums of Chebyshev polynomials with a table of coefficients, at places (4, n) in [-1, 1]."""
    parts = []
    for batch in np.array_split(
        table_coordinates,
        range(POINTS_PER_BATCH, table_coordinates.shape[1], POINTS_PER_BATCH),
        axis=1,
    ):
        part = table[None]
        for coordinate, points in zip(batch[::-1], table.shape[::-1], strict=True):
            part = np.einsum("n...d,nd->n...", part, chebyshev.chebvander(coordinate, points - 1))
        parts.append(part)
    return np.concatenate(parts)
