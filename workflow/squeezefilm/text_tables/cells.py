"""The cells of a table of text: numbers as people and programs write them, and missing ones.

Decimal points or commas, signs between thousands, exponents of Fortran (``1.2D-06``) and of
Mathematica (``1.2*^-6``), a unit behind each number.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import isnan, nan
from typing import Any

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.lazy import pd
from squeezefilm.text_tables.header_cells import normalised_unit

MISSING_PATTERN = re.compile(
    r"|-|--|na|n\.?/?a\.?|k\.a\.|n\.\s?[bdemv]\.?|o\.r\.|null|none|missing|not available"
    r"|#(?:n/a|nv|n/d|div/0!|value!|wert!|valeur!)"
    r"|(?:.*[-+( ])?nan(?:\(\w*\))?(?:\s*[-+].*|\*?[ij])?\)?|-?1\.#\w+",
    re.IGNORECASE,
)
NUMBER_WITH_UNIT_PATTERN = re.compile(r"([-+\u2212]?[\d.,]+(?:[eE][-+]?\d+)?)\s*([^\d\s.,].*)")

SIGNS_OF_PYTHON = str.maketrans({",": ".", "\u2212": "-", "\u2013": "-"})
FORTRAN_EXPONENT_PATTERN = re.compile(r"(?<=[\d.])[dD](?=[-+]?\d)")
POINT_BEFORE_THREE_DIGITS_PATTERN = re.compile(r"[-+]?[1-9]\d{0,2}(?:\.\d{3})+")


def unit_behind_number(cell: str) -> str:
    """The unit that a cell has behind its number, as in ``1.5 mm``; "" of others."""
    match = NUMBER_WITH_UNIT_PATTERN.fullmatch(cell.strip())
    return normalised_unit(match[2]) if match else ""


def is_missing(cell: str) -> bool:
    return bool(MISSING_PATTERN.fullmatch(cell.strip()))


def without_uncertainty(cell: str) -> str:
    """A cell such as ``1.5±0.1`` without what is behind the sign."""
    return re.sub(r"(?<=\d)±[\d.,]+(?:[eE][-+]?\d+)?", "", cell)


def number_of_cell(cell: Any) -> float:
    """The number in a cell; NaN where there is none, as in True or 1_000, which Python reads."""
    if "_" in cell if isinstance(cell, str) else isinstance(cell, bool | np.bool_):
        return nan
    try:
        return float(cell)
    except (TypeError, ValueError):
        return nan


def number_text(cell: str) -> str:
    """A cell with the signs of a number that Python reads: ``1,2D-06`` is ``1.2e-06``."""
    return FORTRAN_EXPONENT_PATTERN.sub("e", cell.translate(SIGNS_OF_PYTHON))


def is_number(cell: str) -> bool:
    """Tell whether a cell is a number with a decimal point or comma."""
    return not isnan(number_of_cell(number_text(cell)))


def parse_numbers(cells: pd.Series) -> pd.Series:
    """Numbers of cells, with decimal points or commas, also ``1.2D-06``; NaN of others."""
    return pd.to_numeric(cells.map(number_text), errors="coerce").astype(float)


def without_units_and_thousands(
    columns: Sequence[tuple[str, str, pd.Series]], separator: str
) -> list[pd.Series]:
    """Cells of columns of numbers without the units behind these and signs between thousands.

    Args:
        columns: of each its name for messages, its unit and its cells by their line.
        separator: what is between cells.

    Raises:
        InputError: where commas and points are both decimal signs, naming a cell with each, and
            where a sign is either a decimal one or between thousands, or units differ.
    """
    if _are_plain([cell for _, _, written in columns for cell in written.tolist()]):
        return [written for _, _, written in columns]
    plain, signs = [], dict[str, tuple[str, object, str]]()
    for name, unit, written in columns:
        cells = written.str.replace("*^", "e", regex=False)
        if unit and any(unit_behind_number(cell) == unit for cell in cells[:1]):
            others = cells[(cells.map(unit_behind_number) != unit) & ~cells.map(is_missing)]
            for line, cell in others[:1].items():
                raise InputError(
                    f"line {line}: {name} is {cell!r}, and {cells.iloc[0]!r} above; write one unit "
                    "into the header, and numbers without units below"
                )
            cells = cells.str.replace(NUMBER_WITH_UNIT_PATTERN, r"\1", regex=True)
        plain.append(_without_thousands_separators(cells))
        for sign in ".,":
            signed = plain[-1][plain[-1].str.contains(rf"\d\{sign}|\{sign}\d", regex=True)]
            for line, cell in signed[:1].items():
                signs.setdefault(sign, (name, line, cell))
    if len(signs) == 2:
        (name, line, cell), (other_name, other_line, other) = signs["."], signs[","]
        raise InputError(
            f"line {line}: {name} has a point in {cell!r}, and line {other_line}: {other_name} a "
            f"comma in {other!r}; one of them must be the decimal sign of all columns"
        )
    for sign, (name, line, cell) in signs.items():
        if _may_be_thousands(plain, sign, separator):
            whole = cell.replace(sign, "")
            raise InputError(
                f"line {line}: {name} is {cell!r}: {cell.replace(sign, '.')} or {whole}? Write "
                f"{whole} if the sign is between thousands; else write numbers with decimal points"
            )
    return plain


def _are_plain(cells: Sequence[str]) -> bool:
    """Tell whether cells are numbers as Python reads them, with points that are decimal ones."""
    pointed = [cell for cell in cells if "." in cell]
    are_grouped = bool(pointed) and all(map(POINT_BEFORE_THREE_DIGITS_PATTERN.fullmatch, pointed))
    return not are_grouped and not any(map(isnan, map(number_of_cell, cells)))


def _may_be_thousands(columns: Sequence[pd.Series], sign: str, separator: str) -> bool:
    """Tell whether a sign may be between thousands: behind it are three digits wherever it is.

    Then numbers are called ambiguous where the sign has to be in quotes, or some of as many digits
    have none.
    """
    cells = pd.concat([*columns])
    signed = cells.str.contains(sign, regex=False)
    grouped = cells[signed].str.fullmatch(rf"[-+]?[1-9]\d{{0,2}}\{sign}\d{{3}}")
    whole = cells[~signed].str.fullmatch(r"[-+]?[1-9]\d{2}")
    return bool(grouped.all() and (sign == separator or whole.any()))


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
