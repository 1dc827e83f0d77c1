"""A table of text as it was exported: its encoding, separator and decimal sign are found.

UTF-8, UTF-16 and Latin-1, with or without a byte order mark; cells separated by commas, semicolons,
tabs or blanks; a decimal point, or a comma where it does not separate cells. Lines before the one
that names columns, and lines that begin with #, are left out.
"""

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from squeezefilm.film.vibration.files.columns import FORM, column_of
from squeezefilm.io.cells import finite_number
from squeezefilm.io.errors import InputError

SEPARATORS = ("\t", ";", ",", None)
"""None: blanks, as many as there are."""
FIRST_LINES = 100
"""Among which the one that names columns is sought."""
FEWEST_NAMED = 2
MISSING = ("", "nan", "na", "n/a", "-")
LARGEST = 1e9


@dataclass(frozen=True)
class TextTable:
    """The header's cells and line, and the rows' cells as text, each with its line in the file."""

    path: Path
    header: list[str]
    header_line: int
    rows: list[list[str]]
    lines: np.ndarray
    notes: list[str]

    def numbers(self, place: int, *, name: str, rows: np.ndarray) -> np.ndarray:
        """The finite numbers in some rows of a column.

        Raises InputError naming the line of a cell that has none.
        """
        cells = [self.rows[row][place] for row in rows]
        if any("," in cell for cell in cells):
            mixed = next((at for at, cell in enumerate(cells) if "." in cell), None)
            if mixed is not None:
                raise InputError(
                    f"{self.path}: line {self.lines[rows[mixed]]}: {name} has a point in "
                    f"{cells[mixed]!r}, and a comma in other rows; one of them must be the decimal "
                    "sign, and nothing stands between thousands"
                )
            cells = [cell.replace(",", ".") for cell in cells]
        try:
            values = np.array(cells, dtype=str).astype(float)
            wrong = not np.all(np.abs(values) <= LARGEST) or any("_" in cell for cell in cells)
        except ValueError:
            wrong = True
        if wrong:
            for row, cell in zip(rows, cells, strict=True):
                line = int(self.lines[row])
                finite_number(cell, path=self.path, line=line, name=name, largest=LARGEST)
        return values

    def measured(self, places: Sequence[int]) -> np.ndarray:
        """The rows that have something in each of some columns."""
        return np.array(
            [
                row
                for row, cells in enumerate(self.rows)
                if not any(cells[place].lower() in MISSING for place in places)
            ],
            dtype=int,
        )


def read_text_table(path: Path) -> TextTable:
    """The cells of a scan's table.

    Raises InputError naming the file, and the line that has more or fewer cells than the header.
    """
    try:
        text, encoding = decoded(path.read_bytes())
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such scan") from None
    except OSError as error:
        raise InputError(f"{path}: the scan cannot be read: {error}") from None
    lines = io.StringIO(text, newline=None).read().split("\n")
    index, separator, commented = _header(lines, path=path)
    if commented:
        lines[index] = lines[index].lstrip("# \t")
    try:
        header, rows, numbers = _cells(lines[index:], separator, first=index + 1)
    except csv.Error as error:
        raise InputError(f"{path}: the scan cannot be read: {error}") from None
    for line, cells in zip(numbers, rows, strict=True):
        if len(cells) != len(header):
            hint = ""
            if separator == "," and len(cells) > len(header):
                hint = "; decimal commas need another separator, such as semicolons"
            raise InputError(
                f"{path}: line {line}: {len(cells)} cells where the header has {len(header)}{hint}"
            )
    notes = [] if encoding in ("utf-8", "ascii") else [f"read as {encoding}"]
    before = sum(bool(line.strip()) and not line.lstrip().startswith("#") for line in lines[:index])
    if before:
        notes.append(f"{before} lines before the header left out")
    return TextTable(path, header, index + 1, rows, np.array(numbers, dtype=int), notes)


def decoded(content: bytes) -> tuple[str, str]:
    """A text and its encoding: by the byte order mark, by zeros between letters, or as it fits."""
    for mark, encoding in (
        (b"\xef\xbb\xbf", "utf-8"),
        (b"\xff\xfe", "utf-16-le"),
        (b"\xfe\xff", "utf-16-be"),
    ):
        if content.startswith(mark):
            return content[len(mark) :].decode(encoding, errors="replace"), encoding
    zeros = np.flatnonzero(np.frombuffer(content[:1000], dtype=np.uint8) == 0)
    if len(zeros) > min(len(content), 1000) / 4:
        encoding = "utf-16-le" if np.mean(zeros % 2) > 0.5 else "utf-16-be"
        return content.decode(encoding, errors="replace"), encoding
    try:
        return content.decode("utf-8"), "utf-8"
    except UnicodeDecodeError:
        return content.decode("latin-1"), "latin-1"


def _header(lines: Sequence[str], *, path: Path) -> tuple[int, str | None, bool]:
    """The place of the line that names columns, its separator, and whether it is a comment."""
    filled = [index for index, line in enumerate(lines) if line.strip(" \t,;")]
    plain = [index for index in filled if not lines[index].lstrip().startswith("#")]
    if not plain:
        raise InputError(f"{path}: the scan is empty; it needs {FORM}")
    comments = [index for index in filled if index not in set(plain[:1]) and index < plain[0]]
    for places, commented in ((plain[:FIRST_LINES], False), (comments[:FIRST_LINES], True)):
        for index in places:
            line = lines[index].lstrip("# \t") if commented else lines[index]
            named = {each: _named(line, each) for each in SEPARATORS}
            best = max(SEPARATORS, key=lambda each: named[each])
            if named[best] >= FEWEST_NAMED:
                return index, best, commented
    first = lines[plain[0]]
    if re.fullmatch(r"[-+\d.,;eE\s]+", first):
        raise InputError(f"{path}: line {plain[0] + 1}: no header names the columns; give {FORM}")
    # Words in the names of columns do not make blanks the separator where there is another one.
    best = next((each for each in SEPARATORS if each and each in first), None)
    names = ", ".join(repr(cell.strip()) for cell in _split(first, best) if not column_of(cell))
    if len(lines) == 1 or _named(first, best) == 0:
        raise InputError(f"{path}: line {plain[0] + 1}: unknown column {names}; a scan has {FORM}")
    return plain[0], best, False


def _named(line: str, separator: str | None) -> int:
    """How many different quantities of a scan a line names."""
    columns = [column_of(cell) for cell in _split(line, separator)]
    return len({column.quantity for column in columns if column})


def _split(line: str, separator: str | None) -> list[str]:
    return line.split(separator)


def _cells(
    lines: Sequence[str], separator: str | None, *, first: int
) -> tuple[list[str], list[list[str]], list[int]]:
    """The header's cells, those of each row that has any, and the rows' lines in the file."""
    numbered: list[tuple[int, list[str]]]
    if separator is None:
        numbered = [(first + at, line.split()) for at, line in enumerate(lines)]
    else:
        reader = csv.reader((f"{line}\n" for line in lines), delimiter=separator, strict=True)
        numbered = [(first - 1 + reader.line_num, cells) for cells in reader]
    kept = [
        (line, [cell.strip() for cell in cells])
        for line, cells in numbered
        if any(cells) and not cells[0].lstrip().startswith("#")
    ]
    kept = [(line, cells) for line, cells in kept if any(cells)]
    (_, header), *rows = kept
    return header, [cells for _, cells in rows], [line for line, _ in rows]
