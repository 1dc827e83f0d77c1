"""The line of a scan's table that names its columns, and the units above, below or beside it."""

from __future__ import annotations

import csv
import re
from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.measured.cells import parse_numbers, unit_behind_number
from squeezefilm.film.measured.columns import (
    ALL_UNITS,
    COORDINATE_UNITS,
    ROW_STATUS_QUANTITIES,
    header_columns,
    header_with_unit_line,
    scan_column_of_cell,
)
from squeezefilm.film.measured.scan import PointRemedies
from squeezefilm.film.measured.table_parts import COMMENT_PATTERN, MAX_TITLE_LINES
from squeezefilm.headers import normalised_unit
from squeezefilm.lazy import pd

# Points of a half or a quarter reach so far beyond the axis, as a share of their extent.
MAX_PART_OVERLAP_FRACTION = 0.05
BLANK_SEPARATOR, WIDE_BLANK_SEPARATOR = " ", "  "
"""Separators: any blanks, and in a header whose names have blanks two or more of them."""
SEPARATORS = ("\t", ";", ",", WIDE_BLANK_SEPARATOR, BLANK_SEPARATOR)
BETWEEN_NAMES_PATTERN = re.compile(r"(?<!,)\s+(?![\[(]|(?:ID|Label|Number|Instance|Name|FOOT-)\b)")
"""Blanks between names in a header, none before a unit in brackets or within ``U, U3``."""
UNCERTAINTY_PATTERN = re.compile(r"(?<=\d)\s*(?:±|\+/-)\s*(?=\d)")
"""The sign between a number and its uncertainty, which is ignored."""
ROW_NAMES = "row names"
"""What the first column is called where it has no name."""
# Among which the line that names columns is sought, and by how many quantities it is known.
MAX_LINES_ABOVE_HEADER, MIN_HEADER_QUANTITIES = 100, 2
LENGTH_UNIT_PATTERN = re.compile(r"(?:length unit|längeneinheit|unité de longueur)\W+(\w+)", re.I)
"""How a program says, above the header, in which unit places are."""
LABVIEW_UNIT_LINE_PREFIX = "Y_Unit_Label"
# A row of numbers, or one that begins with a word, such as a part's name.
NUMBER_ROW_PATTERN = re.compile(r"(?![^\W\d_]{2}|[-=*_]{3})")
NAMED_ROW_PATTERN = re.compile(r".*[\s,;][-+]?\d")
# A table seldom has so many.
MIN_COLUMNS_TAKEN_FOR_MATRIX = 16
MATRIX_LINES_TEXT = "'# Width: 30 mm', '# Height: 20 mm', '# Value units: um'"
USUAL_QUANTITIES_OF_COUNT = {2: ("r", "amplitude"), 3: ("x", "y", "amplitude")}
"""The likely quantities of columns without names, by how many there are, for messages."""


def find_header(
    lines: Sequence[str], *, what: str, form: str, remedies: PointRemedies
) -> tuple[int, list[str], str]:
    """The place of the line that names columns, which may be a comment; its cells; the separator.

    It names some quantities, stands above numbers and has as many cells; others are taken where
    there is none, and one that names a single quantity right above numbers.
    """
    filled = [index for index, line in enumerate(lines) if line.strip(" \t,;")]
    plain = [index for index in filled if not COMMENT_PATTERN.match(lines[index])]
    if not plain:
        raise InputError(f"the {what} is empty; it needs {form}")
    comments = [index for index in filled if index < plain[0]]
    candidates: dict[tuple[bool, bool, int], tuple[int, list[str], str, int]] = {}
    for index in (*plain[:MAX_LINES_ABOVE_HEADER], *comments[-MAX_LINES_ABOVE_HEADER:]):
        line = COMMENT_PATTERN.sub("", lines[index], count=1)
        rows = [lines[row] for row in plain if row > index][:MAX_TITLE_LINES]
        below = next(
            (
                row
                for kind in (NUMBER_ROW_PATTERN, NAMED_ROW_PATTERN)
                for row in rows
                if kind.match(row.strip())
            ),
            "",
        )
        for separator in SEPARATORS:
            between = separator.replace(WIDE_BLANK_SEPARATOR, BLANK_SEPARATOR)
            names = separator == BLANK_SEPARATOR and '"' not in line
            cells = (
                BETWEEN_NAMES_PATTERN.split(line.strip()) if names else split_cells(line, separator)
            )
            known = {column.quantity for column in header_columns(cells)} - {*ROW_STATUS_QUANTITIES}
            count = len(known - {"line"} if known & {*COORDINATE_UNITS} else known)
            if not count:
                continue
            row = split_cells(below, between)
            if between == BLANK_SEPARATOR and len(row) == 1:
                continue
            if (
                len(row) == len(cells) + 1
                and scan_column_of_cell(cells[0])
                and _rows_have_names([lines[at] for at in plain if at > index], between, known)
            ):
                cells = [ROW_NAMES, *cells]
            alike = len(cells) == len(row)
            values = parse_numbers(pd.Series([cell for cell in row if cell], dtype=object))
            numbers = len(values) > 1 and not values.isna().any()
            if count >= MIN_HEADER_QUANTITIES - (alike and numbers and index in plain):
                candidates.setdefault((numbers, alike, count), (index, cells, between, len(row)))
    if candidates:
        index, cells, between, count = candidates[max(candidates)]
        if between == BLANK_SEPARATOR and count != len(cells):
            remedy = (
                "name every column, the first, too, if it has the rows' names"
                if count > len(cells)
                else "put two blanks between the names, and one within them"
            )
            raise InputError(
                f"line {index + 1}: the header has {len(cells)} names between blanks, and the rows "
                f"below {count} cells; {remedy}"
            )
        return index, cells, between
    at = _line_above_numbers([lines[row] for row in plain])
    first = lines[plain[at]].strip()[:60]
    problem = f"line {plain[at] + 1}: no header names the columns: {first!r}; give {form}"
    if len(re.split(r"[\s;,]+", lines[plain[-1]].strip())) >= MIN_COLUMNS_TAKEN_FOR_MATRIX:
        problem += f"; or, of a matrix of amplitudes, lines above it: {MATRIX_LINES_TEXT}"
    points = _points_of_rows_without_names([lines[row] for row in plain])
    raise InputError("; and ".join([problem, *wants_of_points(points, remedies)]))


def _rows_have_names(rows: Sequence[str], separator: str, quantities: Collection[str]) -> bool:
    """Tell whether rows begin with names that the header does not count, as R and pandas do.

    They are words, quoted, or the numbers of the rows, which no coordinate of a plane is.
    """
    cells = [split_cells(row, separator) for row in rows]
    cells = [each for each in cells if len(each) == len(cells[0])]
    names = [each[0] for each in cells]
    are_quoted = all(re.match(r'\s*"[^"]*"[^"\w]*\d', row) for row in rows[: len(cells)])
    are_words = parse_numbers(pd.Series(names, dtype=object)).isna().all()
    start = int(names[0]) if names[0] in ("0", "1") else -1
    are_counted = names == [str(start + at) for at in range(len(names))]
    in_plane = {"x", "y"} <= {*quantities} or {"r", "phi"} <= {*quantities}
    return bool(are_quoted or are_words or (are_counted and in_plane))


def _line_above_numbers(rows: Sequence[str]) -> int:
    """The index of the line of words right above the first row of numbers; 0 if there is none."""
    for index, (above, row) in enumerate(pairwise(rows)):
        cells = pd.Series(re.split(r"[\s;,|]+", row.strip()), dtype=object)
        if parse_numbers(cells).notna().sum() > 1:
            return index if re.match(r"[^\W\d]", above.strip()) else 0
    return 0


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


def header_with_units(
    header: list[str], lines: Sequence[str], index: int, separator: str
) -> tuple[list[str], int]:
    """A header with units above it, in a line below or in the cells; the first line of rows."""
    first = next((row for row in range(index + 1, len(lines)) if lines[row].strip()), len(lines))
    below = "".join(lines[first : first + 1])
    cells = split_cells(COMMENT_PATTERN.sub("", below, count=1), separator) if below else []
    if named := header_with_unit_line(header, cells):
        return named, first + 1
    if len(cells) == len(header):
        header = [
            f"{name} [{unit}]"
            if (unit := unit_behind_number(cell)) in ALL_UNITS and _is_column_without_unit(name)
            else name
            for name, cell in zip(header, cells, strict=True)
        ]
    for line in lines[:index]:
        if line.startswith(LABVIEW_UNIT_LINE_PREFIX):
            cells = ["", *split_cells(line, separator)[1:]]
            header = header_with_unit_line(header, cells) or header
    units = {
        normalised_unit(match[1])
        for line in lines[:index]
        for match in LENGTH_UNIT_PATTERN.finditer(line)
    }
    for unit in units & ALL_UNITS:
        without_unit = {
            column.column_index
            for column in header_columns(header)
            if column.quantity in ("x", "y", "r") and not column.unit
        }
        header = [
            f"{name} [{unit}]" if at in without_unit else name for at, name in enumerate(header)
        ]
    return header, index + 1


def _is_column_without_unit(name: str) -> bool:
    """Tell whether a column that a scan may have is without a unit."""
    column = scan_column_of_cell(name)
    return column is not None and not column.unit


def split_cells(line: str, separator: str) -> list[str]:
    """A line's cells."""
    if separator == WIDE_BLANK_SEPARATOR:
        # COMSOL has a single blank behind a long name.
        return re.split(r"\s\s+| (?=\S+ \(\S+\) @)", line.strip())
    line = UNCERTAINTY_PATTERN.sub("±", line)
    if separator == BLANK_SEPARATOR:
        line = " ".join(line.split())
    try:
        return [
            re.sub(r"(?<=\d)±[\d.,]+(?:[eE][-+]?\d+)?", "", cell.strip())
            for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))
        ]
    except csv.Error as error:
        raise InputError(f"{line[:60]!r} cannot be read: {error}") from None
