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

import contextlib
import csv
import io
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from squeezefilm.errors import InputError, prefix_errors
from squeezefilm.film.measured.arrays import (
    ARRAY_SUFFIXES,
    arrays_as_table_lines,
    matrix_as_table_lines,
)
from squeezefilm.film.measured.cells import (
    distinct_values_text,
    has_complex_pairs,
    is_missing,
    normalise_cells,
    parse_numbers,
    si_values,
    unit_behind_number,
)
from squeezefilm.film.measured.columns import (
    ALL_UNITS,
    COORDINATE_UNITS,
    ROW_STATUS_QUANTITIES,
    UNITS_OF_SCAN_QUANTITY,
    WORDS_OF_MEANING,
    ScanColumn,
    header_columns,
    header_with_unit_line,
    scan_column_of_cell,
    select_columns,
    unit_problems,
)
from squeezefilm.film.measured.scan import (
    FREQUENCY_NEEDED_MESSAGE,
    MIN_SCAN_POINTS,
    NO_REMEDIES,
    SAME_POSITION_DISTANCE_M,
    PointRemedies,
    Scan,
    angular_frequency,
    list_text,
    missing_points_note,
    nearest_spectral_line,
)
from squeezefilm.film.measured.table_parts import (
    COMMENT_PATTERN,
    MAX_TITLE_LINES,
    lines_of_one_table,
)
from squeezefilm.film.measured.validity import valid_rows
from squeezefilm.headers import normalised_unit
from squeezefilm.lazy import pd

SCAN_FORMAT_TEXT = (
    "a row for each point and columns such as x_mm, y_mm, amplitude_um, phase_deg or r_mm, "
    "amplitude_um"
)

# Points of a half or a quarter reach so far beyond the axis, as a share of their extent.
MAX_PART_OVERLAP_FRACTION = 0.05

BLANK_SEPARATOR, WIDE_BLANK_SEPARATOR = " ", "  "
"""Separators: any blanks, and in a header whose names have blanks two or more of them."""
SEPARATORS = ("\t", ";", ",", WIDE_BLANK_SEPARATOR, BLANK_SEPARATOR)
BETWEEN_NAMES_PATTERN = re.compile(r"(?<!,)\s+(?![\[(]|(?:ID|Label|Number|Instance|Name|FOOT-)\b)")
"""Blanks between names in a header, none before a unit in brackets or within ``U, U3``."""
ASIAN_WORDS = [word for words in WORDS_OF_MEANING.values() for word in words if word >= "\u3000"]
# Among which the line that names columns is sought, and by how many quantities it is known.
MAX_LINES_ABOVE_HEADER, MIN_HEADER_QUANTITIES = 100, 2
LENGTH_UNIT_PATTERN = re.compile(r"(?:length unit|längeneinheit|unité de longueur)\W+(\w+)", re.I)
"""How a program says, above the header, in which unit places are."""
REMEDY_OF_FILE_SIGNATURE = {
    b"PK": "save a spreadsheet as CSV, with any separator",
    b"\xd0\xcf\x11\xe0": "export a Polytec file (.svd) as universal file or as text, and save a "
    "spreadsheet (.xls) as CSV",
    b"\x89HDF": "export the points as text or CSV",
    b"%PDF": "export the points as text or CSV",
    b"<?xml": "export the points as CSV (in ParaView: Save Data)",
    b"{": "write the points as CSV",
    b"CDF": "export the points as text or CSV",
    b"\x1f\x8b": "unpack it first",
    b"TDSm": "export the channels as text (.lvm) or CSV, a column each",
    b"CPY": "export the worksheet from Origin as text or CSV",
    b"# vtk": "export the points as CSV (in ParaView: Save Data)",
    b"    1C": "export positions and displacements of the nodes as CSV",
    b"<": "export the points as CSV",
    b"[{": "write the points as CSV",
}
"""How files begin that are no text, or no table, and what to do with them."""
REMEDY_OF_TEXT_PATTERN = {
    r"\$(?:TITLE|SUBTITLE|LABEL) |N A S T R A N|D I S P L A C E M E N T|E I G E N V E C T O R": "a "
    "print or punch file of Nastran's, without positions in the table; export the grid points' "
    "positions and displacements as a universal file (.unv) or as one table: x, y and T3, with "
    "units",
    r"(?m)^\s*(?:LIST ALL SELECTED NODES|PRINT U .*NODAL SOLUTION)": "a list of ANSYS, with "
    "positions and displacements in different tables; export Directional Deformation from "
    "Mechanical (Options, Export, Include Node Location), or write one table: x_m, y_m, uz_m",
    r"(?m)^% Grid\s*$": "a grid of COMSOL's; export with the data format Spreadsheet",
    r"(?m)^\s*VARIABLES\s*=": "a Tecplot file; in place of the lines above the numbers write one "
    "that names the columns, such as x_mm y_mm amplitude_um",
    r"\A# Created by Octave": "variables that Octave saved, one below the other; save them with "
    "'-v7' as named columns (.mat), or write one table such as x_mm y_mm amplitude_um, a row for "
    "each point",
    r"\AIGOR\s": "an Igor text file; save the waves as delimited text",
}
"""What such files of text contain, by patterns, and what to do with them."""
# A component of one sign is sure not to be rectified if it is nowhere less than so much of its
# largest: beside a node line points have less, but in the coarsest of scans.
MIN_COMPONENT_RATIO = 0.4
USABLE_QUANTITIES = {*UNITS_OF_SCAN_QUANTITY, "normal"}
# A table seldom has so many.
MIN_COLUMNS_TAKEN_FOR_MATRIX = 16
MATRIX_LINES_TEXT = "'# Width: 30 mm', '# Height: 20 mm', '# Value units: um'"
USUAL_QUANTITIES_OF_COUNT = {2: ("r", "amplitude"), 3: ("x", "y", "amplitude")}
"""The likely quantities of columns without names, by how many there are, for messages."""
PLAIN_NUMBER_PATTERN = re.compile(r"[-+]?[.,]?\d[\d.,]*(?:[eEdD][-+]?\d+)?$")
LABVIEW_UNIT_LINE_PREFIX = "Y_Unit_Label"
MAX_ENCODING_CHECK_CHARACTERS, MAX_FORMAT_CHECK_CHARACTERS = 1000, 20_000
# How lines above and below rows of numbers begin: column titles' second line, lines, sums.
WORD_LINE_PATTERN = re.compile(r"[^\W\d_]{2,}.*")
RULED_LINE_PATTERN = re.compile(r"[-=*_\s]{3,}")
# A row of numbers, or one that begins with a word, such as a part's name.
NUMBER_ROW_PATTERN = re.compile(r"(?![^\W\d_]{2}|[-=*_]{3})")
NAMED_ROW_PATTERN = re.compile(r".*[\s,;][-+]?\d")
# Of all nodes of a body: the share of a face's, of others, and how far off they are, over the face.
MIN_FACE_FRACTION, MIN_OFF_FRACTION, MIN_OFF_FACE_HEIGHT_FRACTION = 0.1, 0.1, 0.05
# So many rows at a place that differ in time are a time series.
MIN_TIME_SERIES_ROWS = 8
TIME_SERIES_REMEDY = "export amplitude and phase at the actuator's frequency"


def read_point_table(
    path: Path,
    wanted: Collection[str] = tuple(UNITS_OF_SCAN_QUANTITY),
    *,
    what: str,
    form: str,
    complete: Callable[[Collection[str]], dict[str, bool]],
    frequency_hz: float | None = None,
    rows: str | None = None,
    remedies: PointRemedies = NO_REMEDIES,
) -> tuple[pd.DataFrame, list[int], list[str]]:
    """Points of a table of text, by their lines in the file.

    Args:
        wanted: quantities.
        what, form: what the table is and what it needs, for messages.
        complete: the problems of a table with some quantities, and whether it has them.
        frequency_hz: by which velocities become displacements.
        rows: of which measurement, as in ``read_scan``; None where a place may stand repeatedly.
        remedies: as in ``read_scan``.

    Returns: the quantities, in SI units and radians; the lines of points that lack an amplitude,
    which are excluded; and notes on how the file was read.

    Raises:
        InputError: naming the line or column that is wrong.
    """
    lines, notes = _read_lines(path, what=what, form=form)
    index, header, separator = _find_header(lines, what=what, form=form, remedies=remedies)
    with prefix_errors(f"line {index + 1}"):
        header, first = _header_with_units(header, lines, index, separator)
        columns, at_frequency = select_columns(header, wanted, frequency_hz=frequency_hz)
        motion = [columns[name] for name in ("amplitude", "real", "imaginary") if name in columns]
        if len({column.power for column in motion}) > 1:
            raise InputError("real and imaginary part must be both displacements or velocities")
        taken = {column.column_index for column in columns.values()}
        understood = {each.name for each in header_columns(header) if each.quantity != "height"}
        ignored = [repr(name) for name in header if name not in understood]
        beside = f"; not understood: {list_text(ignored)}" * bool(ignored)
        problems = [problem for problem, wrong in complete(columns).items() if wrong]
        elsewhere, second = (
            _columns_of_second_table(lines, first, separator, columns)
            if problems and rows is not None
            else ({}, "")
        )
        if second:
            problems, columns = [second], {**columns, **elsewhere}
        problems[-1:] = [
            f"{problem}; the columns are {', '.join(columns)}{beside}" for problem in problems[-1:]
        ]
        problems += [
            f"a time series ({each.name!r}) is no shape; {TIME_SERIES_REMEDY}"
            for each in header_columns(header)
            if each.quantity == "time" and problems and not motion
        ]
        unplaced = {"r", "phi"} if {"x", "y"} <= {*columns} else set[str]()
        problems += unit_problems([columns[name] for name in columns if name not in unplaced])
        if any(column.power for column in motion) and frequency_hz is None:
            problems.append(FREQUENCY_NEEDED_MESSAGE)
        if problems and path.suffix.lower() in ARRAY_SUFFIXES:
            problems[-1] += ". Units in names of variables follow an underscore: x_mm, vz_m_s"
        if problems:
            points = _numbers_of_columns(lines[first:], separator, columns)
            if _has_component_sign(columns, points):
                remedies = replace(remedies, unsigned="")
            raise InputError("; and ".join([*problems, *_wants_of_points(points, remedies)]))
    needed = max(taken) + 1
    in_columns = at_frequency or any(
        each.quantity == "frequency" for each in header_columns(header)
    )
    lines, joined = lines_of_one_table(
        lines,
        header_line=index,
        first_row=first,
        frequency_hz=None if in_columns else frequency_hz,
        position_of_row=None
        if rows is None
        else partial(_position_cells, separator=separator, columns=columns),
    )
    notes += joined
    cells, beside_rows = _table_cells(lines, first, separator, names=len(header), needed=needed)
    above = sum(bool(line.strip()) and not COMMENT_PATTERN.match(line) for line in lines[:index])
    notes += [f"{above} lines before the header ignored"] * bool(above)
    notes += [*at_frequency, *beside_rows]
    settings = [
        scan_column_of_cell(name, at) or ScanColumn("", "", None, at, name)
        for at, name in enumerate(header)
        if at not in taken
    ]
    cells, settings = _rows_of_requested_measurement(cells, settings, rows or "")
    if rows is not None:
        _reject_points_off_surface(cells, settings, columns)
    cells, states, invalid = valid_rows(cells, settings)
    others = [repr(each.name) for each in settings if each not in states]
    notes += [*[f"ignored columns: {', '.join(others)}"] * bool(others), *invalid]
    amplitudes = cells[[column.column_index for column in motion]]
    lacking = cells.index[amplitudes.map(is_missing).any(axis=1)]
    cells = cells.drop(lacking)
    pairs = [column for column in motion if has_complex_pairs(cells[column.column_index])]
    notes += [f"cells (a,b) of {column.name!r} are read as a + b i" for column in pairs]
    table = pd.DataFrame({name: si_values(cells, column) for name, column in columns.items()})
    if _has_component_sign(columns, table):
        table["sign"] = 1.0
    if rows is not None:
        table, chosen = _one_row_per_position(table, cells, settings, frequency_hz=frequency_hz)
        notes += chosen
    for column in motion:
        if column.power:
            table[column.quantity] /= angular_frequency(frequency_hz) ** column.power
            twice = " squared" * (column.power == 2)
            notes.append(f"{column.name!r} divided by the angular frequency{twice}")
        if column.amplitude_factor != 1:
            table[column.quantity] *= column.amplitude_factor
            notes.append(
                f"{column.name!r} times {column.amplitude_factor:.4g}, a harmonic motion's "
                f"amplitude"
            )
    return table, lacking.tolist(), [*notes, *missing_points_note(lacking.tolist(), what="line")]


def _columns_of_second_table(
    lines: Sequence[str], first: int, separator: str, columns: Mapping[str, ScanColumn]
) -> tuple[dict[str, ScanColumn], str]:
    """Return the columns of another table below that this one lacks, and a message on where."""
    kinds = ({*COORDINATE_UNITS}, {"amplitude", "normal", "real", "imaginary"})
    lacking = [kind for kind in kinds if not kind & columns.keys()]
    if len(lacking) != 1:
        return {}, ""
    for number, (line, below) in enumerate(pairwise(lines[first:]), first + 1):
        header, row = _split_cells(line, separator), _split_cells(below, separator)
        found = {each.quantity: each for each in header_columns(header)}
        places = [each.column_index for name, each in found.items() if name in lacking[0]]
        numbers = parse_numbers(pd.Series(row, dtype=object))
        if places and len(row) == len(header) > 1 and numbers.iloc[places].notna().all():
            known = {name: each for name, each in found.items() if name in USABLE_QUANTITIES}
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
        _split_cells(row, separator) for row in rows if not WORD_LINE_PATTERN.match(row.strip())
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
    if not ("amplitude" in columns and columns["amplitude"].is_signed) or "sign" in columns:
        return False
    amplitude = values["amplitude"]
    return bool(amplitude.min() > MIN_COMPONENT_RATIO * amplitude.max())


def _wants_of_points(points: Mapping[str, pd.Series], remedies: PointRemedies) -> list[str]:
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


def _position_cells(row: str, *, separator: str, columns: dict[str, ScanColumn]) -> tuple[str, ...]:
    """The cells of a row's position; none where one of them is no number."""
    cells = _split_cells(row, separator)
    places = [columns[name].column_index for name in COORDINATE_UNITS if name in columns]
    if max(places) >= len(cells):
        return ()
    position = tuple(cells[place] for place in places)
    return position if all(map(PLAIN_NUMBER_PATTERN.match, position)) else ()


def _rows_of_requested_measurement(
    cells: pd.DataFrame, others: Sequence[ScanColumn], rows: str
) -> tuple[pd.DataFrame, list[ScanColumn]]:
    """The rows of one measurement, as in ``read_scan``, and the columns that they do not set."""
    free = list(others)
    for condition in filter(None, map(str.strip, rows.split(";"))):
        name, _, value = (part.strip() for part in condition.rpartition("="))
        names = {other.name.lower(): other for other in others}
        with prefix_errors(f"actuator.profile.rows: {condition!r}"):
            if name.lower() not in names:
                known = ", ".join(repr(other.name) for other in others)
                raise InputError(f"needs COLUMN = VALUE, the column one of {known}")
            column = names[name.lower()]
            values = normalise_cells(cells[column.column_index])
            cells = cells[values == normalise_cells(pd.Series([value]))[0]]
            if cells.empty:
                raise InputError(f"no row has this value; {distinct_values_text(values)}")
        free = [other for other in free if other is not column]
    return cells, free


def _reject_points_off_surface(
    cells: pd.DataFrame, others: Sequence[ScanColumn], columns: dict[str, ScanColumn]
) -> None:
    """Reject all nodes of a body, many at one height, others far from it; and a surface in x-z."""
    for column in others:
        if column.quantity != "height" or "x" not in columns or cells.empty:
            continue
        x_m, z_m = (
            parse_numbers(cells[each.column_index]) * (each.size or columns["x"].size or 1.0)
            for each in (columns["x"], column)
        )
        flat = [columns[name] for name in ("x", "y") if name in columns]
        flat = [each for each in flat if cells[each.column_index].nunique() == 1]
        if len(flat) == 1 and z_m.nunique() > MIN_SCAN_POINTS:
            raise InputError(
                f"{flat[0].name!r} is {cells[flat[0].column_index].iloc[0]} everywhere, and "
                f"{column.name!r} is not: the surface lies across it; swap the two names in the "
                "header (the motion is that along the surface's normal)"
            )
        heights = normalise_cells(cells[column.column_index])
        common = heights.mode().iloc[-1]
        at_face = heights == common
        apart = abs(z_m - z_m[at_face].iloc[0])
        if (
            at_face.mean() > MIN_FACE_FRACTION
            and (apart > MIN_OFF_FACE_HEIGHT_FRACTION * np.ptp(x_m)).mean() > MIN_OFF_FRACTION
        ):
            raise InputError(
                f"column {column.name!r} has points at several heights, {z_m.min() * 1e3:.4g} to "
                f"{z_m.max() * 1e3:.4g} mm; take those of the surface by actuator.profile.rows: "
                f"{column.name} = {common} or another height; or leave the column out"
            )


def _one_row_per_position(
    table: pd.DataFrame,
    cells: pd.DataFrame,
    others: Sequence[ScanColumn],
    *,
    frequency_hz: float | None,
) -> tuple[pd.DataFrame, list[str]]:
    """The rows of one measurement at each place, and notes on which these are.

    Args:
        table: quantities, whose places may stand repeatedly.
        cells, others: all cells of the same rows, and the columns that are no such quantities.
        frequency_hz: as in ``read_scan``.

    Raises:
        InputError: for a time series, and for several measurements at a place, with the column that
            tells them apart.
    """
    notes = []
    for column in others:
        if column.quantity == "frequency" and column.size:
            values_hz = parse_numbers(cells.loc[table.index, column.column_index]) * column.size
            if not _recurs_at_positions(table, values_hz):
                continue
            if frequency_hz is None:
                raise InputError(f"the rows of {column.name!r} need the actuator's frequency")
            line_hz, far = nearest_spectral_line(values_hz.unique(), frequency_hz)
            if far:
                raise InputError(f"column {column.name!r}: {far}")
            table = table[values_hz == line_hz]
            notes.append(f"rows at {line_hz:.7g} Hz in {column.name!r}")
    place = _position_keys(table)
    if not place.duplicated().any():
        return table, notes
    for column in others:
        values = normalise_cells(cells.loc[table.index, column.column_index])
        differing = values.groupby(place).nunique()[place[place.duplicated()].unique()]
        if differing.median() < 2:
            continue
        recurs = _recurs_at_positions(table, values)
        if column.quantity == "time" and (
            recurs or len(values) >= MIN_TIME_SERIES_ROWS * place.nunique()
        ):
            raise InputError(
                f"column {column.name!r} has several instants at each place: a time series is no "
                f"shape; {TIME_SERIES_REMEDY}"
            )
        if recurs:
            axis = "; or call it x, y or phi, with its unit, if it is the other coordinate"
            axis *= len({"x", "y", "r", "phi"} & {*table}) < 2
            raise InputError(
                f"places have several rows each, which column {column.name!r} tells apart: "
                f"{distinct_values_text(values)}; take one by actuator.profile.rows: {column.name} "
                f"= {values.iloc[0]}{axis}"
            )
    return table, notes


def _position_keys(table: pd.DataFrame) -> pd.Series:
    """A name of each row's place, which rows at the same place share."""
    r, phi = (table.get(name, pd.Series(0.0, table.index)) for name in ("r", "phi"))
    x = table.get("x", r * np.cos(phi))
    y = table.get("y", r * np.sin(phi))
    steps = pd.DataFrame({"x": x, "y": y}).div(SAME_POSITION_DISTANCE_M).round()
    return steps.groupby(["x", "y"], sort=False).ngroup()


def _recurs_at_positions(table: pd.DataFrame, values: pd.Series) -> bool:
    """Tell whether values stand each at many places: those of a setting, no measurement."""
    return 0 < values.nunique() <= 2 * len(values) / _position_keys(table).nunique()


def _incomplete_scan_problems(known: Collection[str]) -> dict[str, bool]:
    """Problems of a scan with some quantities: those that it lacks, or has in excess."""
    place = {*known} & {"x", "y", "r", "phi"}
    both = place > {"x", "y"}
    return {
        "r or phi stands beside x and y; leave it out, or call it amplitude_um or phase_deg": both,
        "the place of a point is x and y, or r and phi, or on a line x, y or r, in the same "
        "table as its amplitude": not both
        and place not in ({"x", "y"}, {"r", "phi"}, {"r"}, {"x"}, {"y"}),
        f"column 'amplitude_um' is missing; a scan has {SCAN_FORMAT_TEXT}": not {*known}
        & {"amplitude", "real", "imaginary"},
        "real and imaginary part go together": len({*known} & {"real", "imaginary"}) == 1,
        "give sign or phase, not both": {"sign", "phase"} <= {*known},
    }


def read_table(path: Path, frequency_hz: float | None, rows: str, remedies: PointRemedies) -> Scan:
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


def _read_lines(path: Path, *, what: str, form: str) -> tuple[list[str], list[str]]:
    """A file's lines, and a note on its encoding."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"the {what} cannot be read: {error}") from None
    if path.suffix.lower() in ARRAY_SUFFIXES:
        return arrays_as_table_lines(path), ["its variables are read as columns"]
    for start, remedy in REMEDY_OF_FILE_SIGNATURE.items():
        if content.startswith(start):
            raise InputError(f"no table of text; {remedy}")
    text, encoding = _decode_text(content)
    for pattern, remedy in REMEDY_OF_TEXT_PATTERN.items():
        if re.search(pattern, text[:MAX_FORMAT_CHECK_CHARACTERS]):
            raise InputError(remedy)
    if text.count("\0", 0, MAX_ENCODING_CHECK_CHARACTERS) > MAX_ENCODING_CHECK_CHARACTERS / 100:
        raise InputError(f"no table of text; export one as text or CSV, with {form}")
    notes = [f"read as {encoding}"] * (encoding != "utf-8")
    lines, matrix = matrix_as_table_lines(io.StringIO(text, newline=None).read().split("\n"))
    return lines, notes + matrix


def _table_cells(
    lines: Sequence[str], first: int, separator: str, *, names: int, needed: int
) -> tuple[pd.DataFrame, list[str]]:
    """The cells below a header of so many names, the first of them needed, by their line.

    Lines above and below rows that all begin with a number are none if their first cell that is
    not empty begins with a word; a note names them.
    """
    rows = {
        number: _split_cells(line, separator)
        for number, line in enumerate(lines[first:], first + 1)
        if line.strip(" \t,;")
        and not COMMENT_PATTERN.match(line)
        and not RULED_LINE_PATTERN.fullmatch(line)
    }
    first_cells = {number: next(filter(None, cells), "") for number, cells in rows.items()}
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
            raise InputError(
                f"line {number}: {len(cells)} cells where the header has {names}{hint}"
            )
    notes = [f"lines beside the rows ignored: {list_text(beside)}"] * bool(beside)
    return pd.DataFrame(list(rows.values()), list(rows), range(names), dtype=object), notes


def _header_with_units(
    header: list[str], lines: Sequence[str], index: int, separator: str
) -> tuple[list[str], int]:
    """A header with units above it, in a line below or in the cells; the first line of rows."""
    first = next((row for row in range(index + 1, len(lines)) if lines[row].strip()), len(lines))
    below = "".join(lines[first : first + 1])
    cells = _split_cells(COMMENT_PATTERN.sub("", below, count=1), separator) if below else []
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
            cells = ["", *_split_cells(line, separator)[1:]]
            header = header_with_unit_line(header, cells) or header
    units = {
        normalised_unit(match[1])
        for line in lines[:index]
        for match in LENGTH_UNIT_PATTERN.finditer(line)
    }
    for unit in units & ALL_UNITS:
        columns = {column.column_index: column for column in header_columns(header)}
        header = [
            f"{name} [{unit}]"
            if at in columns and _is_coordinate_without_unit(columns[at])
            else name
            for at, name in enumerate(header)
        ]
    return header, index + 1


def _is_column_without_unit(name: str) -> bool:
    """Tell whether a column that a scan may have is without a unit."""
    column = scan_column_of_cell(name)
    return column is not None and not column.unit


def _is_coordinate_without_unit(column: ScanColumn) -> bool:
    """Tell whether a column is a coordinate without a unit."""
    return column.quantity in ("x", "y", "r") and not column.unit


def _split_cells(line: str, separator: str) -> list[str]:
    """A line's cells."""
    if separator == WIDE_BLANK_SEPARATOR:
        # COMSOL has a single blank behind a long name.
        return re.split(r"\s\s+| (?=\S+ \(\S+\) @)", line.strip())
    if separator == BLANK_SEPARATOR:
        line = " ".join(line.split())
    try:
        return [
            cell.strip()
            for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))
        ]
    except csv.Error as error:
        raise InputError(f"{line[:60]!r} cannot be read: {error}") from None


def _decode_text(content: bytes) -> tuple[str, str]:
    """A text and its encoding: by the byte order mark, by zeros between letters, or as it fits."""
    start, half = content[:1000], min(len(content), 1000) / 4
    little = start.startswith(b"\xff\xfe") or start[1::2].count(0) > half
    if little or start.startswith(b"\xfe\xff") or start[::2].count(0) > half:
        encoding = "utf-16-le" if little else "utf-16-be"
        return content.decode(encoding, errors="replace").removeprefix("\ufeff"), encoding
    for encoding, words in (("utf-8-sig", [""]), ("cp932", ASIAN_WORDS), ("gb18030", ASIAN_WORDS)):
        with contextlib.suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            if any(word in text for word in words):
                return text, encoding.removesuffix("-sig")
    return content.decode("latin-1"), "latin-1"


def _find_header(
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
    found: dict[tuple[bool, bool, int], tuple[int, list[str], str]] = {}
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
                BETWEEN_NAMES_PATTERN.split(line.strip())
                if names
                else _split_cells(line, separator)
            )
            known = {column.quantity for column in header_columns(cells)} - {*ROW_STATUS_QUANTITIES}
            count = len(known - {"line"} if known & {*COORDINATE_UNITS} else known)
            if not count:
                continue
            row = _split_cells(below, between)
            alike = len(cells) == len(row)
            values = parse_numbers(pd.Series([cell for cell in row if cell], dtype=object))
            numbers = len(values) > 1 and not values.isna().any()
            if count >= MIN_HEADER_QUANTITIES - (alike and numbers and index in plain):
                found.setdefault((numbers, alike, count), (index, cells, between))
    if found:
        index, cells, between = found[max(found)]
        if between == BLANK_SEPARATOR and not max(found)[1]:
            raise InputError(
                f"line {index + 1}: the header has {len(cells)} names between blanks, and the rows "
                "below have not so many cells; put commas, tabs or two blanks between the names"
            )
        return index, cells, between
    first = lines[plain[0]].strip()[:60]
    problem = f"line {plain[0] + 1}: no header names the columns: {first!r}; give {form}"
    if len(re.split(r"[\s;,]+", lines[plain[-1]].strip())) >= MIN_COLUMNS_TAKEN_FOR_MATRIX:
        problem += f"; or, of a matrix of amplitudes, lines above it: {MATRIX_LINES_TEXT}"
    points = _points_of_rows_without_names([lines[row] for row in plain])
    raise InputError("; and ".join([problem, *_wants_of_points(points, remedies)]))


def _points_of_rows_without_names(rows: Sequence[str]) -> dict[str, pd.Series]:
    """The columns of rows by the quantities that they most likely are; none of other rows."""
    cells = [re.split(r"[\s;,]+", row.strip()) for row in rows]
    names = USUAL_QUANTITIES_OF_COUNT.get(len(cells[-1]), ())
    alike = pd.DataFrame([row for row in cells if len(row) == len(names)], dtype=object)
    return {name: parse_numbers(alike[at]) for at, name in enumerate(names)}
