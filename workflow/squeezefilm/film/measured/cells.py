"""The cells of a scan's table: complex numbers (``1.2-0.3i``), signs alone (``+``), decibels."""

from __future__ import annotations

import re
from collections.abc import Collection

from squeezefilm.errors import InputError
from squeezefilm.film.measured.columns import COORDINATE_UNITS, ScanColumn
from squeezefilm.film.measured.scan import MAX_FINITE_VALUE, list_text
from squeezefilm.lazy import pd
from squeezefilm.text_tables.cells import is_missing, parse_numbers, without_units_and_thousands

COMPLEX_PATTERN = r"\(?[\s\d.,eE+-]*\d\s*\*?\s*(?:[ijI]|im)\)?"
PAIR_PATTERN = re.compile(r"\(\s*([-+.\deE]+)\s*[,;]\s*([-+.\deE]+)\s*\)")
"""A complex number as C++, Fortran and Octave write it: ``(1.2,-0.3)``."""
COMPLEX_SIGN_PATTERN = re.compile(r"[ijI∠@°\[(]")
"""What a cell that is no number has if it may be a complex one in another notation."""
IMAGINARY_UNIT_PATTERN = re.compile(r"\*?(?:[ijI]|im)$")
# Cells of a column of signs.
SIGN_OF_CELL = {"+": "1", "-": "-1", "\u2212": "-1", "+1": "1", "1": "1", "-1": "-1"}


def has_complex_pairs(cells: pd.Series) -> bool:
    """Tell whether cells are complex numbers in the form ``(1.2,-0.3)``."""
    return bool(cells.str.fullmatch(PAIR_PATTERN).any())


def normalise_cells(cells: pd.Series) -> pd.Series:
    """Cells in small letters, numbers in one spelling."""
    numbers = parse_numbers(cells)
    return cells.str.strip().str.lower().where(numbers.isna(), numbers.map("{:.9g}".format))


def distinct_values_text(values: pd.Series) -> str:
    """The values of a column in words, the first of many."""
    counts = values.value_counts(sort=False)
    named = [f"{value} ({count} rows)" for value, count in counts.items()]
    return f"it has {list_text(named)}"


def si_values(table: pd.DataFrame, columns: Collection[ScanColumn], separator: str) -> pd.DataFrame:
    """Columns' values in SI units; raises InputError naming the line of one that is no number."""
    cells = {column.quantity: table[column.column_index] for column in columns}
    if "amplitude" in cells:
        # NumPy writes (1.2+-0.3j).
        pairs = cells["amplitude"].str.replace(PAIR_PATTERN, r"\1+\2i", regex=True)
        cells["amplitude"] = pairs.str.replace(r"\+(?=[-+])", "", regex=True)
    plain = without_units_and_thousands(
        [(column.quantity, column.unit, cells[column.quantity]) for column in columns], separator
    )
    return pd.DataFrame(
        {
            column.quantity: _si_values_of_column(cells_of_column, column)
            for column, cells_of_column in zip(columns, plain, strict=True)
        }
    )


def _si_values_of_column(cells: pd.Series, column: ScanColumn) -> pd.Series:
    name = column.quantity
    if name == "sign" and cells.isin(list(SIGN_OF_CELL)).all():
        cells = cells.map(SIGN_OF_CELL)
    values = parse_numbers(cells)
    parts = cells.str.fullmatch(COMPLEX_PATTERN) & (name == "amplitude")
    if parts.any():
        values = values.astype(complex)
        values[parts] = cells[parts].map(_parse_complex)
    if column.in_decibels:
        values = 10 ** (values / 20)
    finite = values.abs() * (column.size or 1.0) <= MAX_FINITE_VALUE
    for line, cell in cells[~finite][:1].items():
        raise InputError(
            f"line {line}: {name} is {cell!r}, not a finite number{_remedy_of_cell(cell, name)}"
        )
    return values * (column.size or 1.0)


def _remedy_of_cell(cell: str, name: str) -> str:
    """Return what to write in place of a cell that is no number; "" of an infinite one."""
    if name in COORDINATE_UNITS:
        return "; every row needs its place, also where it is that of the row above" * is_missing(
            cell
        )
    if not re.search(r"\d|inf", cell):
        return "; write nan as the amplitude of what was not measured"
    is_complex = name == "amplitude" and COMPLEX_SIGN_PATTERN.search(cell)
    return "; a complex amplitude is written as 1.2-0.3i or (1.2,-0.3)" * bool(is_complex)


def _parse_complex(cell: str) -> complex:
    """A number such as ``1.2-0.3i`` or ``1.2 - 0.3*I``; NaN where a cell has none."""
    try:
        parts = "".join(cell.strip("()").split()).replace(",", ".")
        return complex(IMAGINARY_UNIT_PATTERN.sub("j", parts))
    except ValueError:
        return complex("nan")
