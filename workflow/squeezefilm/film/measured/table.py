"""A scan in a table of text.

It is in UTF-8, UTF-16, Latin-1 or Shift JIS, its cells separated by commas, semicolons, tabs or
blanks, with a decimal point, or a comma where it does not separate cells. A row stands for a point;
lines before the one that names columns, those beside numbers that begin with a word, and those that
begin with #, % or !, are ignored. The header names quantities, each with its unit (``x_mm``,
``X [mm]``, ``X/mm``, ``x position mm``), or the line below has the units, or a line above that of
lengths:

    x_mm, y_mm          or  r_mm, phi_deg               place, from the actuator's centre
    x_mm                or  y_mm  or  r_mm              the same on a line through the centre
    amplitude_um        or  real_um, imaginary_um       peak amplitude, or with its sign
    phase_deg           or  sign                        optional
    status              or  valid, overrange            optional

An amplitude may be complex (``1.2-0.3i``), or in decibels with their reference. Velocities (mm/s)
are divided by the angular frequency, accelerations by its square. Of several measurements at each
place one is taken: that at the actuator's frequency, or the rows that are asked for. A row whose
amplitude is empty or ``nan`` is a point that was not measured, and one may be called invalid: both
are excluded from profile and noise, and notes name their lines.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from squeezefilm.errors import InputError, prefix_errors
from squeezefilm.film.measured.cells import has_complex_pairs, si_values
from squeezefilm.film.measured.chosen_rows import (
    TIME_SERIES_REMEDY,
    one_row_per_position,
    reject_points_off_surface,
    rows_of_requested_measurement,
)
from squeezefilm.film.measured.columns import (
    COORDINATE_UNITS,
    SCAN_VOCABULARY,
    UNITS_OF_SCAN_QUANTITY,
    ScanColumn,
    header_columns,
    names_with_frequency_above,
    remedies_of_unused_columns,
    remedy_of_unknown_places,
    scan_column_of_cell,
    select_columns,
    unit_problems,
)
from squeezefilm.film.measured.phases import reject_unclear_phases
from squeezefilm.film.measured.point_remedies import no_header_error, wants_of_points
from squeezefilm.film.measured.scan import (
    NO_REMEDIES,
    PointRemedies,
    Scan,
    list_text,
    missing_points_note,
)
from squeezefilm.film.measured.table_parts import lines_of_one_table
from squeezefilm.film.measured.validity import valid_rows
from squeezefilm.lazy import pd
from squeezefilm.text_tables.arrays import ARRAY_SUFFIXES
from squeezefilm.text_tables.cells import is_missing, parse_numbers, without_uncertainty
from squeezefilm.text_tables.header import (
    BLANK_SEPARATOR,
    COMMENT_PATTERN,
    UNCERTAINTY_PATTERN,
    find_header,
    no_header_text,
    rows_of_lines,
    split_cells,
)
from squeezefilm.text_tables.text_file import read_table_lines

SCAN_FORMAT_TEXT = (
    "a row for each point and columns such as x_mm, y_mm, amplitude_um, phase_deg or r_mm, "
    "amplitude_um"
)

# A component of one sign is sure not to be rectified if it is nowhere less than so much of its
# largest: beside a node line some of so many points have less. Of 60 in five rings they have not
# in 2 % of random modes.
MIN_COMPONENT_RATIO, MIN_COMPONENT_POINTS = 0.4, 100
USABLE_QUANTITIES = {*UNITS_OF_SCAN_QUANTITY, "normal"}
PLAIN_NUMBER_PATTERN = re.compile(r"[-+]?[.,]?\d[\d.,]*(?:[eEdD][-+]?\d+)?$")
# How lines above and below rows of numbers begin: column titles' second line, lines, sums.
WORD_LINE_PATTERN = re.compile(r"[(\[]?[^\W\d_]{2,}.*")
RULED_LINE_PATTERN = re.compile(r"[-=*_\s]{3,}")


def read_point_table(
    path: Path,
    wanted: Collection[str] = tuple(UNITS_OF_SCAN_QUANTITY),
    *,
    what: str,
    form: str,
    complete: Callable[[Collection[str]], dict[str, bool]],
    frequency_hz: float | None = None,
    rows: str = "",
    remedies: PointRemedies = NO_REMEDIES,
) -> tuple[pd.DataFrame, list[int], list[str]]:
    """Points of a table of text, by their lines in the file.

    Args:
        wanted: quantities.
        what, form: what the table is and what it needs, for messages.
        complete: the problems of a table with some quantities, and whether it has them.
        frequency_hz, rows, remedies: of a scan, as in ``read_scan``; without a frequency it is
            none, and a place may stand repeatedly.

    Returns: the quantities, in SI units and radians; the lines of points that lack an amplitude,
    which are excluded; and notes on how the file was read.

    Raises:
        InputError: naming the line or column that is wrong.
    """
    lines, notes = read_table_lines(path, what=what, form=form)
    found = find_header(lines, SCAN_VOCABULARY, what=what, form=form)
    index, first, separator = found.line, found.first_row, found.separator
    header = names_with_frequency_above(found.names, lines[:index], separator)
    if not found.is_known:
        raise no_header_error(no_header_text(found, lines, form=form), lines, remedies)
    with prefix_errors(f"line {index + 1}"):
        columns, at_frequency = select_columns(
            header, wanted, frequency_hz=frequency_hz, above=lines[:index]
        )
        motion = [columns[name] for name in ("amplitude", "real", "imaginary") if name in columns]
        if len({column.power for column in motion}) > 1:
            raise InputError("real and imaginary part must be both displacements or velocities")
        taken = {column.column_index for column in columns.values()}
        understood = {
            column.column_index
            for column in header_columns(header)
            if column.quantity not in {*COORDINATE_UNITS, "height", "line"}
        }
        ignored = [repr(name) for at, name in enumerate(header) if at not in taken | understood]
        beside = f"; not understood: {list_text(ignored)}" * bool(ignored)
        if not motion:
            beside += "".join(
                f"; {remedy}" for remedy in remedies_of_unused_columns(header, columns.values())
            )
        if not {"x", "y", "r"} & columns.keys():
            beside += remedy_of_unknown_places(header)
        problems = [problem for problem, wrong in complete(columns).items() if wrong]
        elsewhere, second = (
            _columns_of_second_table(lines, first, separator, columns)
            if problems and frequency_hz is not None
            else ({}, "")
        )
        if second:
            problems, columns = [second], {**columns, **elsewhere}
        problems[-1:] = [
            f"{problem}; the columns are {', '.join(columns)}{beside}" for problem in problems[-1:]
        ]
        problems[:0] = [
            f"a time series ({column.name!r}) is no shape; {TIME_SERIES_REMEDY}"
            for column in header_columns(header)
            if column.quantity == "time" and problems and not motion
        ]
        unplaced = {"r", "phi"} if {"x", "y"} <= {*columns} else set[str]()
        problems += unit_problems([columns[name] for name in columns if name not in unplaced])
        if problems and path.suffix.lower() in ARRAY_SUFFIXES:
            problems[-1] += ". Units in names of variables follow an underscore: x_mm, vz_m_s"
        if problems:
            points = _numbers_of_columns(lines[first:], separator, columns)
            if _has_component_sign(columns, points):
                remedies = replace(remedies, unsigned="")
            raise InputError("; and ".join([*problems, *wants_of_points(points, remedies)]))
    needed = max(taken) + 1
    in_columns = at_frequency or any(
        column.quantity == "frequency" and (column.size or not column.unit)
        for column in header_columns(header)
    )
    lines, joined = lines_of_one_table(
        lines,
        header_line=index,
        first_row=first,
        frequency_hz=None if in_columns else frequency_hz,
        position_of_row=None
        if frequency_hz is None
        else partial(_position_cells, separator=separator, columns=columns),
    )
    notes += joined
    cells, beside_rows = _table_cells(lines, first, separator, names=len(header), needed=needed)
    above = sum(bool(line.strip()) and not COMMENT_PATTERN.match(line) for line in lines[:index])
    notes += [f"{above} line{'s' * (above > 1)} before the header ignored"] * bool(above)
    uncertain = any(map(UNCERTAINTY_PATTERN.search, lines[first:]))
    notes += ["uncertainties behind ± ignored"] * uncertain
    notes += [*at_frequency, *beside_rows]
    settings = [
        scan_column_of_cell(name, at) or ScanColumn("", "", None, at, name)
        for at, name in enumerate(header)
        if at not in taken
    ]
    cells, settings, in_plane = rows_of_requested_measurement(cells, settings, rows)
    notes += in_plane
    if frequency_hz is not None:
        reject_points_off_surface(cells, settings, columns)
    cells, states, invalid = valid_rows(cells, settings)
    others = [repr(column.name) for column in settings if column not in states]
    notes += [*[f"ignored columns: {', '.join(others)}"] * bool(others), *invalid]
    amplitudes = cells[[column.column_index for column in motion]]
    lacking = cells.index[amplitudes.map(is_missing).any(axis=1)]
    cells = cells.drop(lacking)
    pairs = [column for column in motion if has_complex_pairs(cells[column.column_index])]
    notes += [f"cells (a,b) of {column.name!r} are read as a + b i" for column in pairs]
    table = si_values(cells, columns.values(), separator)
    if _has_component_sign(columns, table):
        table["sign"] = 1.0
        name = columns["amplitude"].name
        notes.append(f"{name!r}, a component, has one sign everywhere: no node line")
    if frequency_hz is None:
        return table, lacking.tolist(), notes
    table, chosen = one_row_per_position(
        table, cells, settings, frequency_hz=frequency_hz, are_chosen=bool(rows)
    )
    notes += chosen
    with prefix_errors(f"line {index + 1}"):
        reject_unclear_phases(table, columns, cells.loc[table.index], settings)
    for column in motion:
        if column.power:
            table[column.quantity] /= (2 * math.pi * frequency_hz) ** column.power
            twice = " squared" * (column.power == 2)
            notes.append(f"{column.name!r} divided by the angular frequency{twice}")
        if column.amplitude_factor != 1:
            table[column.quantity] *= column.amplitude_factor
            notes.append(
                f"{column.name!r} times {column.amplitude_factor:.4g}, a harmonic motion's "
                f"amplitude"
            )
    in_arrays = path.suffix.lower() in ARRAY_SUFFIXES  # whose names are the first line
    missing = missing_points_note(
        (lacking - in_arrays).tolist(), what="row" if in_arrays else "line"
    )
    return table, lacking.tolist(), [*notes, *missing]


def _columns_of_second_table(
    lines: Sequence[str], first: int, separator: str, columns: Mapping[str, ScanColumn]
) -> tuple[dict[str, ScanColumn], str]:
    """Return the columns of another table below that this one lacks, and a message on where."""
    kinds = ({*COORDINATE_UNITS}, {"amplitude", "normal", "real", "imaginary"})
    lacking = [kind for kind in kinds if not kind & columns.keys()]
    if len(lacking) != 1:
        return {}, ""
    for number, (line, below) in enumerate(pairwise(lines[first:]), first + 1):
        header, row = split_cells(line, separator), split_cells(below, separator)
        column_of_quantity = {column.quantity: column for column in header_columns(header)}
        indices = [
            column.column_index for name, column in column_of_quantity.items() if name in lacking[0]
        ]
        numbers = parse_numbers(pd.Series(row, dtype=object))
        if indices and len(row) == len(header) > 1 and numbers.iloc[indices].notna().all():
            known = {
                name: column
                for name, column in column_of_quantity.items()
                if name in USABLE_QUANTITIES
            }
            return known, (
                f"the positions and the amplitudes are in two tables, the second, "
                f"{list_text([repr(name) for name in header])}, from line {number} on; write one "
                "table, with both in the row of a point"
            )
    return {}, ""


def _numbers_of_columns(
    rows: Sequence[str], separator: str, columns: Mapping[str, ScanColumn]
) -> dict[str, pd.Series]:
    """The numbers of columns whose units need not be known, by their quantities."""
    cells = [
        split_cells(row, separator) for row in rows if not WORD_LINE_PATTERN.match(row.strip())
    ]
    return {
        name: parse_numbers(
            pd.Series(["".join(row[at.column_index :][:1]) for row in cells], dtype=object)
        )
        for name, at in columns.items()
    }


def _has_component_sign(
    columns: Mapping[str, ScanColumn], values: Mapping[str, pd.Series] | pd.DataFrame
) -> bool:
    """Tell whether amplitudes are a vector's component, all of one sign and far from a node."""
    if not ("amplitude" in columns and columns["amplitude"].is_signed):
        return False
    amplitude = values["amplitude"]
    if {"sign", "phase", "imaginary"} & {*columns} or np.iscomplexobj(amplitude):
        return False
    return amplitude.count() >= MIN_COMPONENT_POINTS and bool(
        amplitude.min() > MIN_COMPONENT_RATIO * amplitude.max()
    )


def _position_cells(row: str, *, separator: str, columns: dict[str, ScanColumn]) -> tuple[str, ...]:
    """The cells of a row's position; none where one of them is no number."""
    cells = split_cells(row, separator)
    indices = [columns[name].column_index for name in COORDINATE_UNITS if name in columns]
    if max(indices) >= len(cells):
        return ()
    position = tuple(cells[index] for index in indices)
    return position if all(map(PLAIN_NUMBER_PATTERN.match, position)) else ()


def _incomplete_scan_problems(known: Collection[str]) -> dict[str, bool]:
    """Problems of a scan with some quantities: those that it lacks, or has in excess."""
    coordinates = {*known} & {"x", "y", "r", "phi"}
    both = coordinates > {"x", "y"}
    return {
        "r or phi stands beside x and y; leave it out, or call it amplitude_um or phase_deg": both,
        "the place of a point is x and y, or r and phi, or on a line x, y or r, in the same "
        "table as its amplitude": not both
        and coordinates not in ({"x", "y"}, {"r", "phi"}, {"r"}, {"x"}, {"y"}),
        f"column 'amplitude_um' is missing; a scan has {SCAN_FORMAT_TEXT}": not {*known}
        & {"amplitude", "real", "imaginary"},
        "real and imaginary part go together": len({*known} & {"real", "imaginary"}) == 1,
        "give sign or phase, not both": {"sign", "phase"} <= {*known},
    }


def read_table(path: Path, frequency_hz: float, rows: str, remedies: PointRemedies) -> Scan:
    """The scan in a table of text."""
    table, lacking, notes = read_point_table(
        path,
        what="scan",
        form=SCAN_FORMAT_TEXT,
        complete=_incomplete_scan_problems,
        frequency_hz=frequency_hz,
        rows=rows,
        remedies=remedies,
    )
    known = set(table)
    size = table.pop("amplitude").to_numpy() if "amplitude" in known else np.zeros(len(table))
    whole = table.reindex(columns=list(UNITS_OF_SCAN_QUANTITY)).fillna({"sign": 1.0}).fillna(0.0)
    x, y, r, phi, _, real, imaginary, phase, sign = whole.to_numpy(dtype=float).T
    directed, parts = bool(known & {"phase", "sign"}), np.iscomplexobj(size)
    line = not {"x", "y"} <= known and "phi" not in known
    wrong = {
        "sign must be 1 or -1": sign**2 != 1,
        "a complex amplitude has its phase; leave phase and sign out": (size.imag != 0) & directed,
        "amplitude must not be negative where phase or sign tells its direction; if it marks an "
        "invalid row, write nan there": (size.real < 0) & directed & (not parts),
    }
    for problem, where in wrong.items():
        for number in table.index[where][:1]:
            raise InputError(f"line {number}: {problem}")
    amplitude = (size * np.exp(1j * phase) + real + 1j * imaginary) * sign
    z = x + 1j * y + r * np.exp(1j * phi)
    signed = directed or parts or "imaginary" in known or bool(np.any(amplitude.real < 0))
    lines = table.index.to_numpy()
    return Scan(path, z.real, z.imag, amplitude, lines, len(lacking), signed, tuple(notes), line)


def _table_cells(
    lines: Sequence[str], first: int, separator: str, *, names: int, needed: int
) -> tuple[pd.DataFrame, list[str]]:
    """The cells below a header of so many names, the first of them needed, by their line.

    Lines above and below rows that all begin with a number are none if their first cell that is
    not empty begins with a word; a note names them.
    """
    kept = [
        "" if COMMENT_PATTERN.match(line) or RULED_LINE_PATTERN.fullmatch(line) else line
        for line in lines[first:]
    ]
    rows = {
        number: [without_uncertainty(cell) for cell in cells]
        for number, cells in rows_of_lines(kept, separator, start=first)
    }
    # Comments, as Origin has them above the numbers, may begin with empty cells and a number.
    first_cells = {
        number: next(filter(None, cells), "")
        if cells[0] or any(map(PLAIN_NUMBER_PATTERN.match, cells))
        else "comment"
        for number, cells in rows.items()
    }
    start = pd.Series(first_cells, dtype=object)
    words = start.str.fullmatch(WORD_LINE_PATTERN).astype(bool) & ~start.map(is_missing).astype(
        bool
    )
    inside = start.index[~words]
    whole = not inside.empty and not words.loc[inside[0] : inside[-1]].any()
    beside = start.index[words].tolist() if whole else []
    for number in beside:
        del rows[number]
    for number, cells in rows.items():
        # Between blanks an empty cell is none.
        if separator != BLANK_SEPARATOR and needed <= len(cells):
            cells += [""] * (names - len(cells))
        if len(cells) != names:
            hint = "; decimal commas need another separator, such as semicolons"
            hint *= separator == "," and len(cells) > names
            unlike = len(cells) == 1 and bool(re.search(r"\d[\s;,]+[-+]?\d", cells[0]))
            hint += "; separate the rows' cells as the header's" * unlike
            raise InputError(
                f"line {number}: {len(cells)} cells where the header has {names}{hint}"
            )
    many = "s" * (len(beside) > 1)
    notes = [
        f"{len(beside)} line{many} beside the rows ignored (line{many} {list_text(beside)})"
    ] * bool(beside)
    return pd.DataFrame(list(rows.values()), list(rows), range(names), dtype=object), notes
