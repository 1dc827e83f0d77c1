"""Phases of a scan's table that may be in another unit, or against another clock, than they say."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.measured.cells import parse_numbers
from squeezefilm.film.measured.columns import ScanColumn, scan_column_of_cell
from squeezefilm.lazy import pd

REFERENCE_PATTERN = re.compile(r"\bref(?:er[eè]n\w*|\d)?\b[.\s]*", re.IGNORECASE)
# Of a phase that is constant, and of phases of a vibration with node lines, at 0 and 180 degrees.
MIN_CONSTANT_CONCENTRATION, MIN_STANDING_CONCENTRATION = 0.99, 0.9
# Phases beyond this many radians, up to 360, may be degrees.
MAX_WRAPPED_PHASE_RAD = 7.0


def reject_unclear_phases(
    table: pd.DataFrame,
    columns: Mapping[str, ScanColumn],
    cells: pd.DataFrame,
    others: Sequence[ScanColumn],
) -> None:
    """Reject radians that may be degrees, and phases from which another is to be subtracted.

    Args:
        table: quantities in SI units and radians.
        columns: where they come from.
        cells, others: all cells of the same rows, and the columns that are no such quantities.
    """
    if "phase" not in columns or "amplitude" not in columns or not len(table["phase"]):
        return
    name, phase_rad = columns["phase"].name, table["phase"]
    weights = np.abs(table["amplitude"]) ** 2
    concentration = _concentration(2 * phase_rad, weights)
    may_be_degrees = (
        columns["phase"].unit == "rad" and MAX_WRAPPED_PHASE_RAD < abs(phase_rad).max() <= 360
    )
    if may_be_degrees and _concentration(2 * np.radians(phase_rad), weights) > concentration:
        raise InputError(
            f"{name!r} goes from {phase_rad.min():.4g} to {phase_rad.max():.4g}: write deg for rad "
            "into the header if these are degrees; else write radians within ±3.1416"
        )
    for other in others:
        named = scan_column_of_cell(REFERENCE_PATTERN.sub("", other.name), other.column_index)
        if named is None or named.quantity != "phase" or not REFERENCE_PATTERN.search(other.name):
            continue
        reference_rad = parse_numbers(cells[other.column_index]).fillna(0) * (named.size or 1.0)
        if (
            _concentration(reference_rad, np.ones(len(reference_rad))) < MIN_CONSTANT_CONCENTRATION
            and concentration < MIN_STANDING_CONCENTRATION
        ):
            raise InputError(
                f"{other.name!r} varies from point to point, and so does {name!r}: subtract it "
                f"from {name!r} and leave it out; leave it out alone if that is done already"
            )


def _concentration(angles_rad: pd.Series, weights: np.ndarray | pd.Series) -> float:
    """Return the length of the mean of unit vectors: 1 of equal angles, 0 of angles all around."""
    total = float(np.sum(weights))
    return abs(complex(np.sum(weights * np.exp(1j * angles_rad)))) / total if total else 1.0
