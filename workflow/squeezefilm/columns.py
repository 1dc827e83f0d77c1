"""The two forms in which a finger's position stands in tables, polar and Cartesian."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

POLAR, CARTESIAN = ("phi_r_m", "phi_deg"), ("x_m", "y_m")


def form_of(columns: Iterable[object]) -> tuple[str, str]:
    """The form of a table's position: polar, unless the Cartesian one alone is there."""
    names = set(columns)
    return CARTESIAN if names & set(CARTESIAN) and not names & set(POLAR) else POLAR


def as_in(columns: Iterable[str], table: Iterable[object]) -> list[str]:
    """Columns that are named for polar positions, in the form that a table has them in."""
    form = dict(zip(POLAR, form_of(table), strict=True))
    return [form.get(name, name) for name in columns]


def cartesian(phi_r_m: ArrayLike, phi_deg: ArrayLike) -> dict[str, Any]:
    """The Cartesian position of a polar one, or of many as columns."""
    angle = np.radians(phi_deg)
    return {"x_m": phi_r_m * np.cos(angle), "y_m": phi_r_m * np.sin(angle)}
