"""The cells of a CSV file as text, each row with its line in the file; and numbers in them."""

import csv
import io
import math
from pathlib import Path

from squeezefilm.errors import InputError
from squeezefilm.files import read_text


def read_cells(
    path: Path, *, what: str, needs: str
) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The header, and each row's line in the file with its cells; blank lines are left out.

    ``what`` the file is and what it ``needs`` are for messages.
    Raises InputError naming the file, and the line where a row is longer or shorter than the
    header.
    """
    reader = csv.reader(io.StringIO(read_text(path, what=what), newline=""), strict=True)
    try:
        rows = [(reader.line_num, [cell.strip() for cell in cells]) for cells in reader if cells]
    except csv.Error as error:
        raise InputError(f"{path}: the {what} cannot be read: {error}") from None
    if not rows:
        raise InputError(f"{path}: the {what} is empty; it needs {needs}")
    (_, header), *rows = rows
    for line, cells in rows:
        if len(cells) != len(header):
            raise InputError(
                f"{path}: line {line}: {len(cells)} cells where the header has {len(header)}"
            )
    return header, rows


def as_number(cell: str | float) -> float:
    """The number in a cell; NaN where there is none, as in 1_000, which Python would read."""
    try:
        return math.nan if isinstance(cell, str) and "_" in cell else float(cell)
    except ValueError:
        return math.nan
