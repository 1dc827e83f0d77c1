"""Remedies for points of a scan that cannot be read, so that one message has all of them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.measured.columns import COORDINATE_UNITS
from squeezefilm.film.measured.scan import PointRemedies
from squeezefilm.lazy import pd
from squeezefilm.text_tables.arrays import (
    MAX_AXIS_IRREGULARITY,
    MIN_MATRIX_COLUMNS,
    step_irregularity,
)
from squeezefilm.text_tables.cells import is_number, parse_numbers
from squeezefilm.text_tables.header import COMMENT_PATTERN, SEPARATORS, split_cells

# Points of a half or a quarter reach so far beyond the axis, as a share of their extent.
MAX_PART_OVERLAP_FRACTION = 0.05
# A table seldom has so many.
MIN_COLUMNS_TAKEN_FOR_MATRIX = 16
MATRIX_LINES_TEXT = "'# Width: 30 mm', '# Height: 20 mm', '# Value units: um'"
USUAL_QUANTITIES_OF_COUNT = {2: ("r", "amplitude"), 3: ("x", "y", "amplitude")}
"""The likely quantities of columns without names, by how many there are, for messages."""


def no_header_error(problem: str, lines: Sequence[str], remedies: PointRemedies) -> InputError:
    """The message on a table whose columns no line names, and on what its rows need."""
    rows = [line for line in lines if line.strip(" \t,;") and not COMMENT_PATTERN.match(line)]
    if remedy := _remedy_of_axes(rows):
        line, text = remedy
        return InputError(f"line {lines.index(line) + 1}: {text}")
    if len(re.split(r"[\s;,]+", rows[-1].strip())) >= MIN_COLUMNS_TAKEN_FOR_MATRIX:
        problem += f"; or, of a matrix of amplitudes, lines above it: {MATRIX_LINES_TEXT}"
    points = _points_of_rows_without_names(rows)
    return InputError("; and ".join([problem, *wants_of_points(points, remedies)]))


def _remedy_of_axes(rows: Sequence[str]) -> tuple[str, str] | None:
    """A row that is an axis, with even steps as below it, and what to write instead of both."""
    for separator in SEPARATORS[:3]:
        count = len(split_cells(rows[-1], separator))
        alike = [row for row in rows if len(split_cells(row, separator)) == count]
        first, *below = [split_cells(row, separator) for row in alike]
        if is_number(first[0]) or min(len(first), len(below)) < MIN_MATRIX_COLUMNS:
            continue
        axes = [parse_numbers(pd.Series(axis)) for axis in (first[1:], [row[0] for row in below])]
        if all(step_irregularity(axis.to_numpy()) < MAX_AXIS_IRREGULARITY for axis in axes):
            width, height = (f"{len(axis)} × {abs(axis.diff().mean()):g}" for axis in axes)
            return alike[0], (
                "a table of amplitudes with axes; leave out these and words, have x in its rows, "
                f"ascending, and the largest y first, and write lines above it: {MATRIX_LINES_TEXT}"
                " (the number of values times their step: in the first row "
                f"{width}, in the first column {height})"
            )
    return None


def _points_of_rows_without_names(rows: Sequence[str]) -> dict[str, pd.Series]:
    """The columns of rows by the quantities that they most likely are; none of other rows."""
    cells = [re.split(r"[\s;,]+", row.strip()) for row in rows]
    names = USUAL_QUANTITIES_OF_COUNT.get(len(cells[-1]), ())
    alike = pd.DataFrame([row for row in cells if len(row) == len(names)], dtype=object)
    return {name: parse_numbers(alike[at]) for at, name in enumerate(names)}


def wants_of_points(points: Mapping[str, pd.Series], remedies: PointRemedies) -> list[str]:
    """Remedies that points need: they are on a line, on one side, or their motion has no sign."""
    ends = [(points[name].min(), points[name].max()) for name in ("x", "y") if name in points]
    on_line = len(points.keys() & COORDINATE_UNITS) == 1 or (0, 0) in ends
    on_one_side = not on_line and any(
        min(high, -low) < MAX_PART_OVERLAP_FRACTION * (high - low) for low, high in ends
    )
    # An angle beside x and y is a phase that is to be called so.
    directed = points.keys() & {"phase", "sign", "real", "imaginary"} or {"x", "phi"} <= {*points}
    unsigned = not directed and points.get("amplitude", pd.Series([np.nan])).min() >= 0
    wants = (
        remedies.on_line * on_line,
        remedies.on_one_side * on_one_side,
        remedies.unsigned * bool(unsigned),
    )
    return [want for want in wants if want]
