"""The factors of experiments: gap, amplitude, position, and results of physics at these points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError
from squeezefilm.film.positions import (
    CARTESIAN_COLUMNS,
    POLAR_COLUMNS,
    cartesian_from_polar,
    columns_in_table_form,
    polar_from_cartesian,
)
from squeezefilm.lazy import pd
from squeezefilm.tables import ASYMPTOTIC_FORCE_COLUMNS, FACTOR_COLUMNS, read_columns

Array = NDArray[np.float64]

FACTOR_COLUMN_OF_NAME = {
    "h0": "h0_m",
    "hv": "hv_m",
    "r": "phi_r_m",
    "phi": "phi_deg",
    "angle": "phi_rad",
    "x": "x_m",
    "y": "y_m",
}
"""What an expression calls the factors, and their columns."""
PHYSICS_COLUMN_OF_NAME = {"limit": "limit_n", "fast_limit": "fast_limit_n", "sigma": "sigma"}
"""What an expression calls the results of physics that stand in a table, and their columns."""
POSITION_COLUMNS = (*POLAR_COLUMNS, *CARTESIAN_COLUMNS)
RANGE_TOLERANCE = 1e-9
"""Relative slack at the limits of a range, for round-off."""


@dataclass(frozen=True)
class Factors:
    """The factors of n experiments and results of physics at these points.

    columns: by their names, each of shape (n,): h0_m, the mean gap, and hv_m, the vibration
    amplitude at the centre, with epsilon, their ratio; the position of the pad's centre in polar
    (phi_r_m, phi_deg, phi_rad) and Cartesian form (x_m, y_m); results of physics. They are
    attributes too. position: the form in which positions were given. statuses: of the results of
    physics at each point, shape (n,), if they are from a table.
    """

    columns: Mapping[str, Array]
    position_columns: tuple[str, str] = POLAR_COLUMNS
    statuses: NDArray[np.str_] | None = None

    @classmethod
    def of(cls, *, h0_m: ArrayLike, hv_m: ArrayLike, **others: ArrayLike) -> Factors:
        """Factors from numbers or sequences, brought to one length, and results of physics.

        The position is given in polar or in Cartesian form, or none for a centred pad.
        Raises InputError where a value is not finite, a gap is not positive, the lengths differ or
        both forms are given.
        """
        form = CARTESIAN_COLUMNS if others.keys() & CARTESIAN_COLUMNS else POLAR_COLUMNS
        if form == CARTESIAN_COLUMNS and others.keys() & POLAR_COLUMNS:
            raise InputError("x_m: give the position as phi_r_m, phi_deg or as x_m, y_m, not both")
        given = {"h0_m": h0_m, "hv_m": hv_m, **dict.fromkeys(form, 0.0), **others}
        named = {
            name: np.atleast_1d(np.asarray(values_given, float))
            for name, values_given in given.items()
        }
        for name in ("h0_m", "hv_m", *form):
            if not np.all(np.isfinite(named[name])):
                raise InputError(f"{name}: a factor is not a finite number; all must be")
        if np.any(named["h0_m"] <= 0):
            raise InputError("h0_m: a gap is zero or negative; gaps must be positive")
        try:
            named = dict(zip(named, np.broadcast_arrays(*named.values()), strict=True))
        except ValueError:
            lengths = ", ".join(f"{name} {column.size}" for name, column in named.items())
            raise InputError(f"factors of different lengths ({lengths}); give one length") from None
        if form == CARTESIAN_COLUMNS:
            named |= polar_from_cartesian(named["x_m"], named["y_m"])
        else:
            named |= cartesian_from_polar(named["phi_r_m"], named["phi_deg"])
        named["phi_rad"] = np.radians(named["phi_deg"])
        named["epsilon"] = named["hv_m"] / named["h0_m"]
        return cls(named, form)

    def __getattr__(self, name: str) -> Array:
        if name not in vars(self).get("columns", ()):
            raise AttributeError(name)
        return self.columns[name]

    def column(self, name: str) -> Array:
        """A factor, or a result of physics, by the name of its column, shape (n,).

        Raises InputError where the points do not have it.
        """
        if name not in self.columns:
            raise InputError(f"{name}: the points lack this column of the asymptotic forces")
        return self.columns[name]

    def take(self, which: ArrayLike) -> Factors:
        """Some of the points, by a mask or by indices."""
        index = np.asarray(which)
        return Factors(
            {name: each[index] for name, each in self.columns.items()},
            self.position_columns,
            None if self.statuses is None else self.statuses[index],
        )

    def outside_masks(
        self, ranges: Mapping[str, tuple[float, float]]
    ) -> dict[str, NDArray[np.bool_]]:
        """Return masks of the points beyond the range of each factor, shape (n,).

        At the centre no direction is, for all are the same there.
        """
        masks = {}
        for name, (low, high) in ranges.items():
            values, slack = self.column(name), RANGE_TOLERANCE * max(abs(low), abs(high))
            masks[name] = (values < low - slack) | (values > high + slack)
            if name == "phi_deg":
                masks[name] &= self.phi_r_m > RANGE_TOLERANCE * ranges["phi_r_m"][1]
        return masks

    def __len__(self) -> int:
        return len(self.h0_m)


def factors_of_table(points: pd.DataFrame, *, limits: Path | str | None = None) -> Factors:
    """The factors of a table's rows, with the results of physics that it has.

    ``limits`` is a table of the asymptotic forces of the same scenes.
    Raises InputError for values without physical meaning, and where the two tables do not have the
    same scenes in the same order.
    """
    if limits is not None:
        known = read_columns(limits, columns=ASYMPTOTIC_FORCE_COLUMNS)
        for name in columns_in_table_form(FACTOR_COLUMNS, points):
            if len(known) != len(points) or not np.array_equal(known[name], points[name]):
                raise InputError(
                    f"{limits}: {name}: not the scenes of the table of forces; make it from the "
                    "same table of scenes"
                )
        points = known
    names = [*columns_in_table_form(FACTOR_COLUMNS, points), *PHYSICS_COLUMN_OF_NAME.values()]
    given = {name: pd.to_numeric(points[name], "coerce") for name in names if name in points}
    for name, numbers in given.items():
        if (numbers.isna() & points[name].notna()).any():
            raise InputError(f"{name}: a value is not a number")
    has_status = {"limit_n", "status"} <= {*points}
    statuses = points["status"].to_numpy(dtype=str) if has_status else None
    return replace(Factors.of(**given), statuses=statuses)
