"""Pad positions: their two forms, and those of a study in the form of its surface."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from squeezefilm.lazy import pd
from squeezefilm.sections import DERIVED_DEFAULT, BoundedNumber, Section, UniqueItems

POLAR_COLUMNS, CARTESIAN_COLUMNS = ("phi_r_m", "phi_deg"), ("x_m", "y_m")
"""The two forms in which a pad's position stands in tables."""


def find_position_columns(columns: Iterable[object]) -> tuple[str, str]:
    """The form of a table's position: polar, unless the Cartesian one alone is there."""
    names = set(columns)
    return (
        CARTESIAN_COLUMNS
        if names & set(CARTESIAN_COLUMNS) and not names & set(POLAR_COLUMNS)
        else POLAR_COLUMNS
    )


def columns_in_table_form(columns: Iterable[str], table: Iterable[object]) -> list[str]:
    """Columns that are named for polar positions, in the form that a table has them in."""
    form = dict(zip(POLAR_COLUMNS, find_position_columns(table), strict=True))
    return [form.get(name, name) for name in columns]


def fill_missing_coordinate(table: pd.DataFrame) -> pd.DataFrame:
    """The table with both coordinates of its position: 0 for one that it has not."""
    form = (
        find_position_columns(table)
        if {*POLAR_COLUMNS, *CARTESIAN_COLUMNS} & {*table}
        else CARTESIAN_COLUMNS
    )
    return table.assign(**{name: 0.0 for name in form if name not in table})


def cartesian_from_polar(phi_r_m: ArrayLike, phi_deg: ArrayLike) -> dict[str, Any]:
    """The Cartesian position of a polar one, or of many as columns."""
    angle = np.radians(phi_deg)
    return {"x_m": phi_r_m * np.cos(angle), "y_m": phi_r_m * np.sin(angle)}


def polar_from_cartesian(x_m: ArrayLike, y_m: ArrayLike) -> dict[str, Any]:
    """The polar position of a Cartesian one, or of many as columns."""
    return {"phi_r_m": np.hypot(x_m, y_m), "phi_deg": np.degrees(np.arctan2(y_m, x_m))}


OneTo100Items = Field(min_length=1, max_length=100)
Distances = Annotated[list[Annotated[float, BoundedNumber("m", 0, 10)]], OneTo100Items, UniqueItems]


class Positions(Section):
    """Pad positions of the four-factor plan, besides the centre: those written, on a disc in
    polar form, on a rectangle every x with every y; or so many `points` that fill the space up to
    the farthest of those written. The paper's Table II is not legible, so ours are assumed.

    Attributes:
        points: how many positions, the centre among them, that fill the reachable space (a
            scrambled Sobol' sequence, edges too), so that no wave of the profile can alias with
            them; default: 25 where no position is written and the study is not the paper's; else
            none
        phi_r_m: on a disc: distances of the pad's centre from the disc's; default: half of the
            way that the pad may go and stay on the disc, and all of it
        phi_deg: on a disc: directions. Those of 0 … 45 are enough: their mirror images are added as
            far as the scene lacks a square's symmetry (docs/reference/configuration.md); default:
            0, 22.5 and 45 on a disc
        x_m: on a rectangle: distances of the pad's centre from the y axis. Both sides of it are
            meant: images at −x are added unless pad and vibration make them the same; default: on a
            rectangle, 0, half of the way that the pad may go along x, and all of it
        y_m: the same along y; default: the same along y
    """

    points: Annotated[int, Field(strict=True, ge=4, le=1000)] = DERIVED_DEFAULT
    phi_r_m: Annotated[
        list[Annotated[float, BoundedNumber("m", 0, 10, open=True)]], OneTo100Items, UniqueItems
    ] = DERIVED_DEFAULT
    phi_deg: Annotated[
        list[Annotated[float, BoundedNumber("°", 0, 360)]], OneTo100Items, UniqueItems
    ] = DERIVED_DEFAULT
    x_m: Distances = DERIVED_DEFAULT
    y_m: Distances = DERIVED_DEFAULT
