"""Tables one after the other in a file of text: pages of one, or one at each frequency."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.measured.columns import FREQUENCY_UNITS_HZ, WORDS_OF_MEANING
from squeezefilm.film.measured.scan import (
    MAX_MODE_DISTANCE_FRACTION,
    list_text,
    nearest_spectral_line,
)
from squeezefilm.text_tables.header import COMMENT_PATTERN, MAX_TITLE_LINES
from squeezefilm.text_tables.header_cells import fold_accents

FREQUENCY_WORDS = [word for word in WORDS_OF_MEANING["frequency"] if word not in ("f", "hz", "khz")]
FREQUENCY_LINE_PATTERN = re.compile(
    r"(?:\A[#%!\s]*|\d\s+)(?:(?:excitation|drive|driving|anregungs|激励|励振|加振)\s*)?"
    rf"(?:{'|'.join(FREQUENCY_WORDS)})\W*?(?:[\[(]([kmg]?hz)[\])])?[\s\"]*[:=;,\t]"
    r"[\s\"=]*(\d+(?:[.,]\d*)?(?:e[-+]?\d+)?)\s*([kmg]?hz)?[\s\";,]*(?:\(.*)?$"
)
"""How a line above a header tells the frequency of the table below it."""
UNIT_IN_BRACKETS_PATTERN = re.compile(r"\s*[\[(][^\[\]()]*[\])]|_[mu]?m\b")

Position = tuple[str, ...]


@dataclass(frozen=True)
class TextTable:
    """A table of a file: the index of its header's line, its rows', and its frequency if told."""

    header_line: int
    rows: range
    frequency_hz: float | None


def lines_of_one_table(
    lines: Sequence[str],
    *,
    header_line: int,
    first_row: int,
    frequency_hz: float | None,
    position_of_row: Callable[[str], Position] | None,
) -> tuple[list[str], list[str]]:
    """Return the lines with those of other tables empty, and notes on what was chosen or joined.

    Args:
        header_line, first_row: indices of the first table's header and first row.
        frequency_hz: which tables are wanted where lines above headers tell their frequencies.
        position_of_row: the cells of a row's position, () if it has none; None where tables are
            not joined.

    Raises:
        InputError: for a second table of the same positions, and tables at another frequency.
    """
    tables = _tables_under_header(lines, header_line, first_row)
    chosen, notes = _tables_at_frequency(tables, frequency_hz)
    if len(tables) == 1:
        return list(lines), notes
    if position_of_row is None:
        raise _second_table_error(tables[1])
    kept = {*range(first_row)}
    table_of_position = dict[Position, TextTable]()
    for table in chosen:
        positions = {row: position_of_row(lines[row]) for row in table.rows}
        for row, position in positions.items():
            if position and table_of_position.setdefault(position, table) != table:
                raise _second_table_error(table)
            if position:
                kept.add(row)
    return [line if number in kept else "" for number, line in enumerate(lines)], notes


def _second_table_error(table: TextTable) -> InputError:
    return InputError(
        f"line {table.header_line + 1}: the header stands again: a second table; keep the rows of "
        "one, or join them below one header"
    )


def _tables_under_header(lines: Sequence[str], header_line: int, first_row: int) -> list[TextTable]:
    """Tables under one header, whose units may differ; one without a frequency has that before."""
    header = lines[header_line]
    names = UNIT_IN_BRACKETS_PATTERN.sub("", header).split()
    header_lines = [header_line]
    if not COMMENT_PATTERN.match(header):
        header_lines += [
            number
            for number in range(first_row, len(lines))
            if lines[number].lstrip()[:1] == header.lstrip()[:1]
            and UNIT_IN_BRACKETS_PATTERN.sub("", lines[number]).split() == names
        ]
    tables: list[TextTable] = []
    frequency_hz, title_begin = None, 0
    for start, end in pairwise([*header_lines, len(lines)]):
        frequency_hz = frequency_of_lines(lines[title_begin:start]) or frequency_hz
        tables.append(TextTable(start, range(start + first_row - header_line, end), frequency_hz))
        title_begin = max(start, end - MAX_TITLE_LINES - 1)
    return tables


def _tables_at_frequency(
    tables: Sequence[TextTable], frequency_hz: float | None
) -> tuple[Sequence[TextTable], list[str]]:
    """The tables at the frequency nearest to the one wanted, all where none is told; and notes."""
    told_hz = [table.frequency_hz for table in tables if table.frequency_hz]
    joined = [f"{len(tables)} tables with one header joined"] * (len(tables) > 1)
    if not frequency_hz or not told_hz:
        return tables, joined
    line_hz, far = nearest_spectral_line(np.array(told_hz), frequency_hz)
    several = len({*told_hz}) > 1
    if abs(line_hz / frequency_hz - 1) > MAX_MODE_DISTANCE_FRACTION or (far and several):
        raise InputError(f"a line above the header tells another frequency: {far}")
    chosen = [table for table in tables if table.frequency_hz == line_hz]
    if several:
        told_text = list_text([f"{table_hz:.7g}" for table_hz in told_hz])
        return chosen, [f"read at {line_hz:.7g} Hz, of tables at {told_text} Hz"]
    return chosen, joined + [f"read at {line_hz:.7g} Hz"] * (line_hz != frequency_hz)


def frequency_of_lines(lines: Sequence[str]) -> float | None:
    """The frequency in the last of some lines that tells one: ``FREQ: 4.327E+04``."""
    for match in map(FREQUENCY_LINE_PATTERN.search, map(fold_accents, reversed(lines))):
        if match:
            unit = match[1] or match[3] or "hz"
            return float(match[2].replace(",", ".")) * FREQUENCY_UNITS_HZ[unit] or None
    return None
