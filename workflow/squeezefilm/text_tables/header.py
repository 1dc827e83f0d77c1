"""The line of a table that names its columns, and the units above, below or beside it.

What words mean is up to the vocabulary of each kind of table. The header is the line that names
most of its columns above rows of as many cells; where none names any, that of words above numbers.
"""

from __future__ import annotations

import csv
import re
from bisect import bisect
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

from squeezefilm.errors import InputError, prefix_errors
from squeezefilm.text_tables.cells import is_number, unit_behind_number, without_uncertainty
from squeezefilm.text_tables.header_cells import normalised_unit

COMMENT_PATTERN = re.compile(r"\A\s*[#%!][#%!\s]*")
MAX_TITLE_LINES = 5
"""Lines of a title or of units above or below a header."""
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
# A row of numbers, or one that begins with a word, such as a part's name.
NUMBER_ROW_PATTERN = re.compile(r"(?![^\W\d_]{2}|[-=*_]{3})")
NAMED_ROW_PATTERN = re.compile(r".*[\s,;][-+]?\d")


@dataclass(frozen=True)
class Column:
    """A quantity, the unit it is in ("" if none is named), its place in a row, and its name.

    ``size`` is the unit's in SI units (radians for a scan's angles); None of one that the quantity
    has not.
    """

    quantity: str
    unit: str
    size: float | None
    column_index: int
    name: str


class Vocabulary:
    """The columns that a kind of table may have, and their units.

    Attributes:
        units: all that columns have.
        places: quantities whose unit a line above the header may tell.
        planes: sets of quantities that no numbers of rows can be beside.
    """

    units: Collection[str]
    places: Collection[str]
    planes: Sequence[Collection[str]] = ()

    def column(self, cell: str, column_index: int = 0) -> Column | None:
        """The column that a cell of a header names; None for one that the table does not have."""
        raise NotImplementedError

    def columns(self, header: Sequence[str]) -> Sequence[Column]:
        """The columns that a header names."""
        named = (self.column(name, at) for at, name in enumerate(header))
        return [column for column in named if column]

    def quantities(self, header: Sequence[str]) -> Collection[str]:
        """The quantities by which a header is known."""
        return {column.quantity for column in self.columns(header)}

    def size_of_unit(self, cell: str) -> float | None:
        """The size of the unit in a cell of a line of units; None of one that is not known."""
        raise NotImplementedError

    def size_in_name(self, name: str) -> float | None:
        """The size of the unit that a column's name has; None where it has none that is known."""
        own = self.column(name)
        return own.size if own and own.unit else None


@dataclass(frozen=True)
class Header:
    """Names of columns with their units; indices of its line and of the first line below."""

    names: list[str]
    separator: str
    line: int
    first_row: int
    is_known: bool


@dataclass(frozen=True)
class _Candidate:
    """A line that may be the header: its cells, and how many a row below has.

    ``rank`` is whether that row has numbers alone and as many cells, and the quantities named.
    """

    rank: tuple[bool, bool, int]
    line: int
    cells: list[str]
    separator: str
    row_cells: int


def find_header(lines: Sequence[str], vocabulary: Vocabulary, *, what: str, form: str) -> Header:
    """The header of a table, which may be a comment.

    Of the lines that name two quantities or more, one above numbers is preferred, then one above
    as many cells, then the one that names most, then the first. A single quantity suffices above
    as many numbers, but not in a comment. Where no line suffices, ``is_known`` is false.

    Args:
        what, form: what the table is and what it needs, for messages.

    Raises InputError for an empty table, and for names and cells that blanks do not separate alike.
    """
    filled = [index for index, line in enumerate(lines) if line.strip(" \t,;")]
    plain = [index for index in filled if not COMMENT_PATTERN.match(lines[index])]
    if not plain:
        raise InputError(f"the {what} is empty; it needs {form}")
    are_numbers = (sum(map(is_number, re.split(r"[\s;,]+", lines[index]))) > 1 for index in plain)
    first_row = next((at for at, row in enumerate(are_numbers) if row), 0)
    comments = [index for index in filled if index < plain[first_row] and index not in plain]
    candidates = [
        candidate
        for index in (*plain[:MAX_LINES_ABOVE_HEADER], *comments[-MAX_LINES_ABOVE_HEADER:])
        for candidate in _candidates_of_line(
            lines, index, plain[bisect(plain, index) :], vocabulary
        )
    ]
    if not candidates:
        return _header_of_unknown_names(lines, plain, first_row)
    best = max(candidates, key=lambda candidate: candidate.rank)
    if best.separator == BLANK_SEPARATOR and len(best.cells) != best.row_cells:
        remedy = (
            "name every column, the first, too, if it has the rows' names"
            if best.row_cells > len(best.cells)
            else "put two blanks between the names, and one within them"
        )
        raise InputError(
            f"line {best.line + 1}: the header has {len(best.cells)} names between blanks, and the "
            f"rows below {best.row_cells} cells; {remedy}"
        )
    with prefix_errors(f"line {best.line + 1}"):
        names, first = _names_with_units(best.cells, lines, best.line, best.separator, vocabulary)
    return Header(names, best.separator, best.line, first, True)


def _candidates_of_line(
    lines: Sequence[str], index: int, rows: Sequence[int], vocabulary: Vocabulary
) -> Iterator[_Candidate]:
    """A line's names by each separator that fits the rows below, whose indices are ``rows``."""
    line = COMMENT_PATTERN.sub("", lines[index], count=1)
    is_plain = line == lines[index]
    below = _first_row_of([lines[row] for row in rows[:MAX_TITLE_LINES]])
    for separator in SEPARATORS:
        between = separator.replace(WIDE_BLANK_SEPARATOR, BLANK_SEPARATOR)
        cells = split_cells(line, separator)
        if separator == BLANK_SEPARATOR and '"' not in line:
            cells = BETWEEN_NAMES_PATTERN.split(line.strip())
        if 2 * sum(map(is_number, cells)) > len(cells):
            continue
        known = vocabulary.quantities(cells)
        row = split_cells(below, between) if known else []
        if not known or (between == BLANK_SEPARATOR and _are_blanks_in_names(line, below, cells)):
            continue
        if (
            len(row) == len(cells) + 1
            and vocabulary.column(cells[0])
            and _rows_have_names(
                [lines[row] for row in rows],
                between,
                are_in_plane=any({*plane} <= {*known} for plane in vocabulary.planes),
            )
        ):
            cells = [ROW_NAMES, *cells]
        values = [without_uncertainty(cell) for cell in row if cell]
        numbers = len(values) > 1 and all(map(is_number, values))
        alike = len(cells) == len(row)
        if len(known) >= MIN_HEADER_QUANTITIES - (alike and numbers and is_plain):
            yield _Candidate((numbers, alike, len(known)), index, cells, between, len(row))


def _first_row_of(rows: Sequence[str]) -> str:
    """The first row of numbers, else the first that begins with a word; "" if there is none."""
    return next(
        (
            row
            for kind in (NUMBER_ROW_PATTERN, NAMED_ROW_PATTERN)
            for row in rows
            if kind.match(row.strip())
        ),
        "",
    )


def _are_blanks_in_names(line: str, below: str, cells: Sequence[str]) -> bool:
    """Tell whether blanks do not separate cells: a row has one, or as many by another sign."""
    row = split_cells(below, BLANK_SEPARATOR)
    return len(row) == 1 or (
        len(cells) != len(row)
        and any(
            1 < len(split_cells(line, sign)) == len(split_cells(below, sign))
            for sign in SEPARATORS[:3]
        )
    )


def _header_of_unknown_names(lines: Sequence[str], plain: Sequence[int], first_row: int) -> Header:
    """The line of as many words as the rows below have cells, else that above the first numbers."""
    for at, index in enumerate(plain[:MAX_LINES_ABOVE_HEADER], start=1):
        for separator in SEPARATORS[:3]:
            names = split_cells(lines[index], separator)
            rows = [split_cells(lines[row], separator) for row in plain[at : at + MAX_TITLE_LINES]]
            are_rows = all(len(row) == len(names) and any(map(is_number, row)) for row in rows)
            if rows and are_rows and len(names) > 1 and not any(map(is_number, names)):
                return Header(names, separator, index, index + 1, False)
    above = plain[max(first_row - 1, 0)]
    index = above if re.match(r"\s*[^\W\d]", lines[above]) else plain[0]
    separator = max(SEPARATORS[:3], key=lines[index].count)
    separator = separator if separator in lines[index] else BLANK_SEPARATOR
    return Header(split_cells(lines[index], separator), separator, index, index + 1, False)


def no_header_text(header: Header, lines: Sequence[str], *, form: str) -> str:
    """The message on a table whose columns no line names, with the line that may be meant."""
    line = lines[header.line].strip()[:60]
    return f"line {header.line + 1}: no header names the columns: {line!r}; give {form}"


def _rows_have_names(rows: Sequence[str], separator: str, *, are_in_plane: bool) -> bool:
    """Tell whether rows begin with names that the header does not count, as R and pandas do.

    They are words, quoted, or the numbers of the rows, which no coordinate of a plane is.
    """
    cells = [split_cells(row, separator) for row in rows]
    cells = [row for row in cells if len(row) == len(cells[0])]
    names = [row[0] for row in cells]
    are_quoted = all(re.match(r'\s*"[^"]*"[^"\w]*\d', row) for row in rows[: len(cells)])
    are_words = not any(map(is_number, names))
    start = int(names[0]) if names[0] in ("0", "1") else -1
    are_counted = names == [str(start + at) for at in range(len(names))]
    return bool(are_quoted or are_words or (are_counted and are_in_plane))


def _names_with_units(
    names: list[str], lines: Sequence[str], index: int, separator: str, vocabulary: Vocabulary
) -> tuple[list[str], int]:
    """Names with units above them, in a line below or in the cells; the first line of rows."""
    first = next((row for row in range(index + 1, len(lines)) if lines[row].strip()), len(lines))
    below = "".join(lines[first : first + 1])
    cells = split_cells(COMMENT_PATTERN.sub("", below, count=1), separator) if below else []
    if named := _names_with_unit_line(names, cells, vocabulary):
        return named, first + 1
    if len(cells) == len(names):
        units = [unit_behind_number(cell) for cell in cells]
        names = [_name_lacking_unit(*each, vocabulary) for each in zip(names, units, strict=True)]
    for line in lines[:index] if separator != BLANK_SEPARATOR else ():  # blanks are in titles
        label, *cells = split_cells(COMMENT_PATTERN.sub("", line, count=1), separator)
        sizes = [vocabulary.size_of_unit(cell.strip(" []()")) for cell in cells if cell]
        if 1 < len(sizes) > 2 * sizes.count(None) and len(cells) + 2 >= len(names):
            label = "" if vocabulary.size_of_unit(label.strip(" []()")) is None else label
            names = _names_with_unit_line(names, [label, *cells], vocabulary) or names
    for line in lines[:index]:
        for match in LENGTH_UNIT_PATTERN.finditer(line):
            unit = normalised_unit(match[1])
            names = [_name_lacking_unit(name, unit, vocabulary, are_places=True) for name in names]
    return names, index + 1


def _name_lacking_unit(
    name: str, unit: str, vocabulary: Vocabulary, *, are_places: bool = False
) -> str:
    """A column's name with a unit that is known, if it has none; of places alone if so asked."""
    own = vocabulary.column(name) if unit in vocabulary.units else None
    lacks = (
        own
        and own.size is None
        and not own.unit
        and (own.quantity in vocabulary.places or not are_places)
    )
    return f"{name} [{unit}]" if lacks else name


def _names_with_unit_line(
    names: Sequence[str], cells: Sequence[str], vocabulary: Vocabulary
) -> list[str] | None:
    """Names with the units of the line below them; None if that line is not of units.

    It is one if half of what it names are known units, and none a number: one that is not known is
    named in a message if its column is needed.
    """
    cells = [cell.strip(" []()") for cell in cells]
    known = [vocabulary.size_of_unit(cell) is not None for cell in cells]
    are_few = 2 * sum(known) < sum(map(bool, cells))
    are_numbers = any(re.match(r"[-+]?[.,]?\d", cell) for cell in cells)
    if not any(known) or are_few or are_numbers or len(cells) > len(names):
        return None
    return [
        _name_with_unit(name, cell, vocabulary)
        for name, cell in zip_longest(names, cells, fillvalue="")
    ]


def _name_with_unit(name: str, cell: str, vocabulary: Vocabulary) -> str:
    """A column's name with the unit of a cell, unless it has one that is known.

    Raises:
        InputError: where the two are known and differ.
    """
    size, own = vocabulary.size_of_unit(cell), vocabulary.size_in_name(name)
    if own is not None:
        if size not in (None, own):
            raise InputError(
                f"{name!r} has another unit in the line of units: {cell!r}; leave one of them out"
            )
        return name
    is_unit = size is not None or (cell.strip("-") and vocabulary.column(name))
    return f"{name} [{cell}]" if is_unit else name


def split_cells(line: str, separator: str) -> list[str]:
    """A line's cells."""
    if separator == WIDE_BLANK_SEPARATOR:
        # COMSOL has a single blank behind a long name.
        return re.split(r"\s\s+| (?=\S+ \(\S+\) @)", line.strip())
    return next((cells for _, cells in rows_of_lines([line], separator)), [""])


def rows_of_lines(
    lines: Sequence[str], separator: str, start: int = 0
) -> list[tuple[int, list[str]]]:
    """The rows of lines without those that are blank: each row's line in the file, and its cells.

    A cell in quotes may go over several lines; where quotes do not end, each line is a row.

    Args:
        start: how many lines the file has above these.
    """
    if separator == BLANK_SEPARATOR:
        lines = [" ".join(line.split()) for line in lines]
    if any("±" in line or "+/-" in line for line in lines):
        lines = [UNCERTAINTY_PATTERN.sub("±", line) for line in lines]
    how: dict[str, Any] = {"delimiter": separator, "skipinitialspace": True}
    reader = csv.reader(lines, strict=True, **how)
    try:
        rows = [(start + reader.line_num, [*map(str.strip, cells)]) for cells in reader]
    except csv.Error:
        parts = (next(csv.reader([line], **how), []) for line in lines)
        rows = [(at, [*map(str.strip, cells)]) for at, cells in enumerate(parts, start=start + 1)]
    return [row for row in rows if any(row[1])]
