"""The cells of a scan's table: numbers as people and programs write them, and missing ones.

Decimal points or commas, signs between thousands, exponents of Fortran (``1.2D-06``), complex
numbers (``1.2-0.3i``), signs alone (``+``), decibels.
"""

from __future__ import annotations

import re

from squeezefilm.errors import InputError
from squeezefilm.film.measured.columns import COORDINATE_UNITS, ScanColumn
from squeezefilm.film.measured.scan import MAX_FINITE_VALUE, list_text
from squeezefilm.headers import normalised_unit
from squeezefilm.lazy import pd

COMPLEX_PATTERN = r"\(?[\s\d.,eE+-]*\d\s*\*?\s*(?:[ijI]|im)\)?"
PAIR_PATTERN = re.compile(r"\(\s*([-+.\deE]+)\s*[,;]\s*([-+.\deE]+)\s*\)")
"""A complex number as C++, Fortran and Octave write it: ``(1.2,-0.3)``."""
COMPLEX_SIGN_PATTERN = re.compile(r"[ijI∠@°\[(]")
"""What a cell that is no number has if it may be a complex one in another notation."""
IMAGINARY_UNIT_PATTERN = re.compile(r"\*?(?:[ijI]|im)$")
MISSING_PATTERN = re.compile(
    r"|-|--|na|n\.?/?a\.?|k\.a\.|n\.\s?[bdemv]\.?|o\.r\.|null|none|missing|not available"
    r"|#(?:n/a|nv|n/d|div/0!|value!|wert!|valeur!)"
    r"|(?:.*[-+( ])?nan(?:\(\w*\))?(?:\s*[-+].*|\*?[ij])?\)?|-?1\.#\w+",
    re.IGNORECASE,
)
NUMBER_WITH_UNIT_PATTERN = re.compile(r"([-+\u2212]?[\d.,]+(?:[eE][-+]?\d+)?)\s*([^\d\s.,].*)")
# Cells of a column of signs.
SIGN_OF_CELL = {"+": "1", "-": "-1", "\u2212": "-1", "+1": "1", "1": "1", "-1": "-1"}


def unit_behind_number(cell: str) -> str:
    """The unit that a cell has behind its number, as in ``1.5 mm``; "" of others."""
    match = NUMBER_WITH_UNIT_PATTERN.fullmatch(cell.strip())
    return normalised_unit(match[2]) if match else ""


def is_missing(cell: str) -> bool:
    return bool(MISSING_PATTERN.fullmatch(cell.strip()))


def has_complex_pairs(cells: pd.Series) -> bool:
    """Tell whether cells are complex numbers in the form ``(1.2,-0.3)``."""
    return bool(cells.str.fullmatch(PAIR_PATTERN).any())


def parse_numbers(cells: pd.Series) -> pd.Series:
    """Numbers of cells, with decimal points or commas, also ``1.2D-06``; NaN of others."""
    points = (
        cells.str.replace(",", ".")
        .str.replace("[\u2212\u2013]", "-", regex=True)
        .str.replace(r"(?<=\d)[dD](?=[-+]?\d)", "e", regex=True)
    )
    return pd.to_numeric(points, errors="coerce").astype(float)


def normalise_cells(cells: pd.Series) -> pd.Series:
    """Cells in small letters, numbers in one spelling."""
    numbers = parse_numbers(cells)
    return cells.str.strip().str.lower().where(numbers.isna(), numbers.map("{:.9g}".format))


def distinct_values_text(values: pd.Series) -> str:
    """The values of a column in words, the first of many."""
    counts = values.value_counts(sort=False)
    named = [f"{value} ({count} rows)" for value, count in counts.items()]
    return f"it has {list_text(named)}"


def si_values(table: pd.DataFrame, column: ScanColumn) -> pd.Series:
    """A column's values in SI units; raises InputError naming the line of one that is none."""
    cells, name = table[column.column_index].str.replace("*^", "e", regex=False), column.quantity
    if column.unit and any(unit_behind_number(cell) == column.unit for cell in cells[:1]):
        with_unit = cells.map(unit_behind_number) == column.unit
        cells = cells.mask(
            with_unit, cells.str.replace(NUMBER_WITH_UNIT_PATTERN, r"\1", regex=True)
        )
    if name == "amplitude":
        # NumPy writes (1.2+-0.3j).
        cells = cells.str.replace(PAIR_PATTERN, r"\1+\2i", regex=True)
        cells = cells.str.replace(r"\+(?=[-+])", "", regex=True)
    cells = _without_thousands_separators(cells)
    digits = cells.str.contains(r"\d")
    comma, point = (cells.str.contains(sign, regex=False) & digits for sign in ",.")
    if comma.any() and point.any():
        line, cell = next(cells[point].items())
        raise InputError(
            f"line {line}: {name} has a point in {cell!r}, and a comma in other rows; one of them "
            "must be the decimal sign"
        )
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


def _without_thousands_separators(cells: pd.Series) -> pd.Series:
    """Cells without blanks and signs between thousands, where a cell with both signs tells them."""
    cells = cells.str.replace(r"(?<=\d)[\s'’](?=\d{3}(?!\d))", "", regex=True)
    for decimal, between in ((",", "."), (".", ",")):
        whole = rf"[-+]?\d{{1,3}}(?:\{between}\d{{3}})+"
        told = cells.str.fullmatch(rf"{whole}(?:\{decimal}\d+|\{between}\d{{3}})").any()
        elsewhere = cells.str.replace(whole, "", regex=True).str.contains(between, regex=False)
        if told and not elsewhere.any():
            return cells.str.replace(between, "", regex=False)
    return cells


def _parse_complex(cell: str) -> complex:
    """A number such as ``1.2-0.3i`` or ``1.2 - 0.3*I``; NaN where a cell has none."""
    try:
        parts = "".join(cell.strip("()").split()).replace(",", ".")
        return complex(IMAGINARY_UNIT_PATTERN.sub("j", parts))
    except ValueError:
        return complex("nan")
