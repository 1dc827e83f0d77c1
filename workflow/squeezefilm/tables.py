"""The tables that pass between the stages: their columns, reading with checks, writing.

A table is CSV, or Parquet where its file name ends in ``.parquet``: for plans so large that text
would take longer to read than scenes to solve.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from itertools import zip_longest
from math import nan
from pathlib import Path
from typing import Any, Literal

import numpy as np

from squeezefilm.columns import TEXT_COLUMNS, unregistered_columns
from squeezefilm.errors import (
    MAX_ROWS_IN_MESSAGE,
    InputError,
    RunError,
    imports_from_extra,
    prefix_errors,
    raise_row_problems,
)
from squeezefilm.files import atomic_file, read_bytes, read_text, write_text
from squeezefilm.film.positions import (
    CARTESIAN_COLUMNS,
    POLAR_COLUMNS,
    columns_in_table_form,
    fill_missing_coordinate,
)
from squeezefilm.headers import fold_accents, normalised_unit, possible_words_and_units
from squeezefilm.lazy import pd
from squeezefilm.solution import SOLUTION_COLUMNS
from squeezefilm.units import unit_sizes

FACTOR_COLUMNS = ("h0_m", "hv_m", *POLAR_COLUMNS)
"""Here and below, positions are named in polar form; columns_as_in takes a table's own names."""
SCENE_COLUMNS = ("point_id", *FACTOR_COLUMNS)
DESIGN_COLUMNS = (*SCENE_COLUMNS, "origin")
TIMING_COLUMNS = ("point_id", "solve_s")
ASYMPTOTIC_FORCE_COLUMNS = (
    *SCENE_COLUMNS,
    "limit_n",
    "fast_limit_n",
    "sigma",
    "limit_error_n",
    "status",
)
REFINEMENT_ROUND_COLUMNS = (
    "simulations",
    "global_error",
    "global_lower",
    "global_upper",
    "worst_error",
)
"""What a reader of a refinement's rounds may count on; the table has more."""
ERROR_MAP_COLUMNS = (*FACTOR_COLUMNS, "layer", "error_n")
MEASUREMENT_UNCERTAINTY_COLUMNS = ("force_uncertainty_n", "h0_uncertainty_m", "hv_uncertainty_m")
# What a table of measured forces has, for messages.
MEASURED_COLUMNS_TEXT = (
    "h0 [µm], hv [µm], force [mN] and force uncertainty [mN], each with its unit; and, where they "
    "are known, a position, h0 uncertainty [µm], hv uncertainty [µm] and point_id"
)
POSITION_FORMS = f"{' and '.join(POLAR_COLUMNS)}, or {' and '.join(CARTESIAN_COLUMNS)}"
POSITION_FORMS_TEXT = f"a position is {POSITION_FORMS}"
PARQUET_SUFFIX, COMMENT_SIGNS, MAX_LINES_ABOVE_HEADER = ".parquet", ("#", "%", "!"), 20
CSV_SEPARATORS, BLANK_SEPARATOR = ",;\t", " "
UNSUPPORTED_SUFFIXES = {".xlsx", ".xls", ".ods", ".json", ".feather", ".h5", ".hdf5", ".mat", ".nc"}
"""Names of files that are expected to hold something else than text in columns."""
FORCE_COLUMNS = (*SCENE_COLUMNS, *SOLUTION_COLUMNS)
"""Of forces; derivatives and outputs stand behind them."""
OPTIONAL_FORCE_COLUMNS = {*SOLUTION_COLUMNS} - {
    "force_n",
    "force_error_n",
    "status",
    "absent_terms",
}
"""Columns of forces that a table may lack."""
_WORDS_OF_COLUMN = {
    "h0_m": "h0;h 0;gap;mean gap;spalt;jeu;entrefer;holgura;traferro;spleet;ギャップ;间隙",
    "hv_m": "hv;h v;amplitude;vibration amplitude;disp ampl;amplitud;ampiezza;振幅;振動振幅",
    "x_m": "x;x position;position x;x座標",
    "y_m": "y;y position;position y;y座標",
    "phi_r_m": "phi r",
    "phi_deg": "phi",
    "force_n": "force;f;kraft;fuerza;forza;forca;kracht;力",
}
COLUMN_OF_WORDS = {
    fold_accents(words): name
    for name, several in _WORDS_OF_COLUMN.items()
    for words in several.split(";")
}
"""What people call columns, each also with a word of uncertainty, and units beside it."""
UNCERTAINTY_WORDS = {
    *("uncertainty", "unsicherheit", "messunsicherheit", "incertitude", "incertidumbre"),
    *("incertezza", "incerteza", "onzekerheid", "不確かさ", "不确定度"),
}
UNIT_SIZES_OF_BASE_UNIT = {
    unit.lower(): {fold_accents(name): size for name, size in unit_sizes(unit).items()}
    for unit in ("m", "deg", "N")
}
KNOWN_UNIT_NAMES = {name for units in UNIT_SIZES_OF_BASE_UNIT.values() for name in units}

OtherColumnsPolicy = Literal["invalid", "unknown are invalid", "ignored", "kept"]
"""What becomes of columns that a table has beside those that are read; unknown are those that
columns.csv does not have, and invalid where others are kept too."""


def chunk_row_slice(chunk: int, chunks: int, count: int) -> slice:
    """The rows of one of several chunks: contiguous parts that differ by at most one row."""
    return slice(count * (chunk - 1) // chunks, count * chunk // chunks)


def read_scenes(path: Path | str, *, chunk: tuple[int, int] = (1, 1)) -> pd.DataFrame:
    """Read a plan: ``point_id`` as text, the four factors as finite numbers, order kept.

    Rows without a ``point_id`` are called by their line; without positions the pad is centred.
    A factor of a CSV table may have another unit. Results that the table has are not read.

    Args:
        chunk: which of how many parts of it.

    Raises InputError naming the file, the row or the column that is wrong.
    """
    how: dict[str, Any] = {"others": "unknown are invalid", "chunk": chunk}
    return _read_table(path, columns=SCENE_COLUMNS, numbers=FACTOR_COLUMNS, **how)


def read_design(path: Path | str) -> pd.DataFrame:
    """Read a design: the columns of a plan and ``origin``, which says how a point was chosen.

    Raises InputError naming the file, the row or the column that is wrong.
    """
    how: dict[str, Any] = {"numbers": FACTOR_COLUMNS, "others": "unknown are invalid"}
    return _read_table(path, columns=DESIGN_COLUMNS, **how)


def read_measurements(path: Path | str) -> pd.DataFrame:
    """Read measured forces with their standard uncertainties.

    Points without a name are called by their line. Uncertainties of gap and amplitude are 0 where
    the table has none.

    Raises InputError naming the file, the row or the column that is wrong, and what is allowed.
    """
    numbers = (*FACTOR_COLUMNS, "force_n", *MEASUREMENT_UNCERTAINTY_COLUMNS)
    how: dict[str, Any] = {
        "optional": MEASUREMENT_UNCERTAINTY_COLUMNS[1:],
        "required": MEASURED_COLUMNS_TEXT,
    }
    table = _read_table(path, columns=("point_id", *numbers), numbers=numbers, **how)
    return table.assign(**{name: table.get(name, 0.0) for name in MEASUREMENT_UNCERTAINTY_COLUMNS})


def read_timings(path: Path | str) -> pd.DataFrame:
    """Read the solver's share of wall time per point.

    Raises InputError naming the file, the row or the column that is wrong.
    """
    return _read_table(path, columns=TIMING_COLUMNS, numbers=("solve_s",))


def read_forces(path: Path | str, *, whole: bool = False) -> pd.DataFrame:
    """Read simulated forces; a row whose status is not ``ok`` may lack its force.

    Args:
        whole: with the derivatives and the outputs that the table has.

    Raises InputError naming the file, the row or the column that is wrong.
    """
    how: dict[str, Any] = {
        "optional": OPTIONAL_FORCE_COLUMNS,
        "others": "kept" if whole else "unknown are invalid",
    }
    table = _read_table(path, columns=FORCE_COLUMNS, numbers=FACTOR_COLUMNS, **how)
    for name in map(str, table):
        if name in ("force_n", "force_error_n") or name not in {*FORCE_COLUMNS, *TEXT_COLUMNS}:
            table[name] = pd.to_numeric(table[name], errors="coerce").astype(float)
    for name in ("force_n", "force_error_n"):
        bad = table.loc[(table["status"] == "ok") & ~np.isfinite(table[name]), "point_id"]
        if len(bad):
            raise InputError(f"{path}: point {bad.iloc[0]}: {name} is not a finite number")
    return table


def read_ok_forces(path: Path | str) -> pd.DataFrame:
    """Read simulated forces of which every one is needed.

    Raises InputError naming the points that were not solved.
    """
    table = read_forces(path)
    if failures := failed_point_texts(table):
        raise InputError(no_force_message(failures, path))
    return table


def failed_point_texts(forces: pd.DataFrame) -> list[str]:
    """The points of a table without a force, each with its reason."""
    failed = forces[forces["status"] != "ok"]
    return [f"point {row.point_id}: {row.status}" for row in failed.itertuples()]


def no_force_message(failures: Sequence[str], source: Path | str) -> str:
    """The message for points without a force."""
    beyond = len(failures) - MAX_ROWS_IN_MESSAGE
    more = f" and {beyond} more" if beyond > 0 else ""
    return f"{source}: no force for {'; '.join(failures[:MAX_ROWS_IN_MESSAGE])}{more}"


def _read_table(
    path: Path | str,
    *,
    columns: Sequence[str],
    numbers: Sequence[str],
    optional: Collection[str] = (),
    others: OtherColumnsPolicy = "invalid",
    required: str = "",
    chunk: tuple[int, int] = (1, 1),
) -> pd.DataFrame:
    """The columns of a table, and what becomes of others that it has.

    Args:
        columns: of these ``point_id`` and a position may be missing: rows are called by their
            place, and the pad is centred.
        numbers: those that must be finite.
        optional: others that may be missing.
        required: what the table needs, for messages.
    """
    path, optional = Path(path), (*optional, "point_id", *POLAR_COLUMNS, *CARTESIAN_COLUMNS)
    how: dict[str, Any] = {"optional": optional, "others": others, "chunk": chunk}
    table, lines = _read_rows(
        path, columns, required=required or _columns_text(columns, optional), **how
    )
    word = "row" if path.suffix == PARQUET_SUFFIX else "line"
    source, statuses = f"{path}: {word}", table.get("status")
    wanted = [name for name in columns_in_table_form(columns, table) if name in table]
    table = table[wanted + [name for name in table if name not in wanted] * (others == "kept")]
    problems: list[tuple[int, str]] = []
    for name in [each for each in columns_in_table_form(numbers, wanted) if each in wanted]:
        cells = table[name].tolist()
        values = np.array([*map(number_of_cell, cells)], dtype=float)
        for row in np.flatnonzero(~np.isfinite(values)).tolist():
            called = table.attrs.get(name, name)
            problem = f"{called} is {cells[row]!r}, not a finite number"
            why = "" if statuses is None else f"; its status is {statuses.iloc[row]!r}"
            problems.append((row, problem + why))
        for row in np.flatnonzero(
            (values <= 0) & (name in MEASUREMENT_UNCERTAINTY_COLUMNS)
        ).tolist():
            problems.append((row, f"{name} is {values[row]:g}; it must be above 0"))
        table[name] = values
    if problems and "h0_m" in table:  # of numbers alone, the check of scenes finds it
        contact = [row for row, h0_m in enumerate(table["h0_m"]) if h0_m <= 0]
        problems += [
            (row, f"h0_m is {table['h0_m'].iloc[row]:g}; it must be above 0") for row in contact
        ]
    if "point_id" not in table:
        table.insert(0, "point_id", [f"{word} {line}" for line in lines])
    ids = table["point_id"] = table["point_id"].astype("str")
    empty = ids.isna() | (ids == "")
    problems += [(row, "point_id is empty") for row in np.flatnonzero(empty).tolist()]
    first = dict(zip(reversed(ids.tolist()), reversed(lines), strict=True))
    for row in np.flatnonzero(ids.duplicated() & ~empty).tolist():
        name = ids.iloc[row]
        problems.append((row, f"point_id {name!r} stands in {word} {first[name]} already"))
    raise_row_problems([f"{source} {lines[row]}: {problem}" for row, problem in sorted(problems)])
    if POLAR_COLUMNS[0] in columns:
        table = fill_missing_coordinate(table)
    return (
        table if path.suffix == PARQUET_SUFFIX else table.iloc[chunk_row_slice(*chunk, len(table))]
    )


def _read_rows(
    path: Path,
    columns: Sequence[str],
    *,
    optional: Collection[str],
    others: OtherColumnsPolicy,
    required: str,
    chunk: tuple[int, int] = (1, 1),
) -> tuple[pd.DataFrame, list[int]]:
    """All rows of a CSV file but blank ones as text, or some of a Parquet file; the line of each.

    Columns that a header names in words or with another unit are brought to their own; others stay.
    """
    if path.suffix == PARQUET_SUFFIX:
        table, lines = _read_parquet_rows(path, chunk=chunk)
    else:
        table, lines = _read_csv_rows(path, columns=columns, required=required)
    header = list(map(str, table))
    with prefix_errors(path):
        asked = columns_in_table_form(columns, header)
        optional = [*optional, *columns_in_table_form(optional, header)]
        _check_header(header, asked, optional, others=others, required=required)
    if not lines:
        raise InputError(f"{path}: the table has a header and no rows")
    return table, lines


def _read_csv_rows(
    path: Path, *, columns: Iterable[str], required: str
) -> tuple[pd.DataFrame, list[int]]:
    from squeezefilm.film.measured.text_file import lines_of_text  # as long as a small film

    with prefix_errors(path):
        lines, _ = lines_of_text(read_bytes(path, what="table"), form=required)
    start, separator = _find_header(lines, columns)
    text = io.StringIO("\n".join(lines[start:]).lstrip("#%! "), newline="")
    reader = csv.reader(text, delimiter=separator, skipinitialspace=True, strict=True)
    try:
        cells_of = ([cell.strip() for cell in cells] for cells in reader)
        rows = [(start + reader.line_num, cells) for cells in cells_of if any(cells)]
    except csv.Error as error:
        raise InputError(f"{path}: the table cannot be read: {error}") from None
    if not rows:
        raise InputError(f"{path}: the table is empty; it needs {required}")
    width = max(at for at, name in enumerate(rows[0][1], start=1) if name)
    for _, cells in rows:
        if not any(cells[width:]):
            del cells[width:]
    # A row's name may begin with the sign.
    rows = [row for row in rows if len(row[1]) == width or not row[1][0].startswith(COMMENT_SIGNS)]
    (_, header), *rows = rows
    if "point_id" not in header:  # pandas writes rows' names in a column without one
        header[0] = header[0] or "point_id"
    units = [normalised_unit(cell) for _, cells in rows[:1] for cell in cells]
    if {*units} & KNOWN_UNIT_NAMES and {*units} <= {*KNOWN_UNIT_NAMES, ""}:
        header = [
            name + f" [{unit}]" * bool(unit)
            for name, unit in zip_longest(header, units, fillvalue="")
        ]
        del rows[0]
    raise_row_problems(
        [
            f"{path}: line {line}: {len(cells)} cells where the header has {len(header)}"
            for line, cells in rows
            if len(cells) != len(header)
        ]
    )
    numbers = [line for line, _ in rows]
    table = pd.DataFrame([cells for _, cells in rows], numbers, range(len(header)), dtype="str")
    if separator != ",":
        for column_index, name in enumerate(header):
            table[column_index] = _with_decimal_points(table[column_index], place=f"{path}: {name}")
    names = list(header)
    for column_index, own, size in _renamed_columns_of_header(header, columns):
        names[column_index] = own
        table[column_index] = [_cell_in_si(cell, size) for cell in table[column_index]]
    table = table.set_axis(names, axis=1).reset_index(drop=True)
    table.attrs = dict(zip(names, header, strict=True))  # for messages
    return table, numbers


def _find_header(lines: Sequence[str], columns: Iterable[str]) -> tuple[int, str]:
    """The place of the line that names columns, which may be a comment, and the separator of cells.

    It is the first one that names two, or one; where none does, the first that is no comment.
    """
    asked = _asked_columns(columns)
    filled = [index for index, line in enumerate(lines) if line.strip()]
    for least in (2, 1):
        for index in filled[:MAX_LINES_ABOVE_HEADER]:
            separators = [each for each in CSV_SEPARATORS if each in lines[index]]
            for separator in separators or BLANK_SEPARATOR:
                cells = [cell.strip('" ') for cell in lines[index].strip("#%! ").split(separator)]
                named = sum(bool({cell, _column_and_unit_size(cell)[0]} & asked) for cell in cells)
                if named >= least:
                    return index, separator
    plain = next((index for index in filled if not lines[index].startswith(COMMENT_SIGNS)), 0)
    return plain, max(CSV_SEPARATORS, key="".join(lines[plain : plain + 1]).count)


def _asked_columns(columns: Iterable[str]) -> set[str]:
    """Columns in either form of a position."""
    columns = list(columns)
    return {
        *columns_in_table_form(columns, ()),
        *columns_in_table_form(columns, CARTESIAN_COLUMNS),
    }


def _renamed_columns_of_header(
    header: Sequence[str], columns: Iterable[str]
) -> Iterator[tuple[int, str, float]]:
    """Columns that a header names in words or with another unit.

    Yields their numbers in the header, their own names, and the size of the unit.
    """
    asked = _asked_columns(columns)
    for column_index, name in enumerate(header):
        own, size = _column_and_unit_size(name)
        if name not in asked and own in asked - {*header} and size:
            yield column_index, own, size


def normalise_points(
    points: pd.DataFrame | Mapping[str, Any], *, needed: Sequence[str]
) -> pd.DataFrame | Mapping[str, Any]:
    """Points that no file holds, their factors under their own names and in SI units.

    A header is read as that of a table in a file.

    Args:
        needed: factors that may not be missing.

    Raises InputError naming the column that is missing, not known or without its unit.
    """
    names = list(map(str, points))
    renamed = {
        names[k]: (own, size) for k, own, size in _renamed_columns_of_header(names, FACTOR_COLUMNS)
    }
    if renamed:
        table = points if isinstance(points, pd.DataFrame) else pd.DataFrame(points)
        scaled = {
            name: [float(f"{number_of_cell(cell) * size:.15g}") for cell in table[name]]
            for name, (_, size) in renamed.items()
        }
        points = table.assign(**scaled).rename(
            columns={name: own for name, (own, _) in renamed.items()}
        )
    header = list(map(str, points))
    columns = columns_in_table_form(SCENE_COLUMNS, header)
    optional = [name for name in columns if name not in needed]
    required = _columns_text(columns, optional)
    _check_header(header, columns, optional, others="unknown are invalid", required=required)
    return points


def _columns_text(columns: Sequence[str], optional: Collection[str]) -> str:
    """The columns that a table needs and those that it may have, for messages."""
    needed = [name for name in columns if name not in optional]
    position = {*POLAR_COLUMNS, *CARTESIAN_COLUMNS}
    offered = [name for name in columns if name in {*optional} - position]
    if position & {*columns}:
        offered.append(f"a position ({POSITION_FORMS})")
    parts = {"": needed, "it may have ": offered}
    return "; ".join(f"{start}{', '.join(names)}" for start, names in parts.items() if names)


def _column_and_unit_size(cell: str) -> tuple[str, float | None]:
    """The column that a header's cell names, and the size of its unit; None of one without."""
    for words, unit in possible_words_and_units(cell, KNOWN_UNIT_NAMES):
        named = [word for word in words if word not in UNCERTAINTY_WORDS]
        text = " ".join(named).removesuffix(" standard")
        columns = {
            COLUMN_OF_WORDS.get(word) for word in ([text] if text in COLUMN_OF_WORDS else named)
        }
        if len(columns) == 1 and (own := columns.pop()):
            stem, _, base = own.rpartition("_")
            name = f"{stem}_uncertainty_{base}" if named != words else own
            return name, UNIT_SIZES_OF_BASE_UNIT[base].get(unit)
    return cell, None


def _with_decimal_points(cells: pd.Series, *, place: str) -> pd.Series:
    """Cells of which the numbers have no decimal commas; both signs in a column are invalid."""
    commas = cells.str.fullmatch(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
    points = cells.str.fullmatch(r"[-+]?\d*\.\d+(?:[eE][-+]?\d+)?")
    if commas.any() and points.any():
        (line, one), (_, other) = next(cells[points].items()), next(cells[commas].items())
        raise InputError(f"{place}: a point in {one!r} (line {line}), and a comma in {other!r}")
    return cells.where(~commas, cells.str.replace(",", "."))


def _cell_in_si(cell: str, size: float) -> str:
    """Return the number in a cell times the size of its unit, the cell where there is none."""
    value = number_of_cell(cell)
    return cell if size == 1 or value != value else f"{value * size:.15g}"


def _read_parquet_rows(path: Path, *, chunk: tuple[int, int]) -> tuple[pd.DataFrame, list[int]]:
    """Some rows of a Parquet file, and their numbers; no others are held."""
    with imports_from_extra("parquet", what="a table in Parquet"):
        import pyarrow as pa
        import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path) as file:
            about = file.metadata
            row_counts = [about.row_group(group).num_rows for group in range(about.num_row_groups)]
            ends = np.cumsum(row_counts, dtype=int)
            asked = range(about.num_rows)[chunk_row_slice(*chunk, about.num_rows)]
            groups = np.flatnonzero((ends > asked.start) & (ends - row_counts < asked.stop))
            read = file.read_row_groups(groups.tolist())
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such table") from None
    except (OSError, pa.ArrowException) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{path}: the table cannot be read: {reason}") from None
    before = sum(row_counts[: groups[0]]) if len(groups) else 0
    rows_read = read.slice(asked.start - before, len(asked)).to_pandas()
    return rows_read, [row + 1 for row in asked]


def number_of_cell(cell: Any) -> float:
    """The number in a cell; NaN where there is none, as in True or 1_000, which Python reads."""
    if "_" in cell if isinstance(cell, str) else isinstance(cell, bool | np.bool_):
        return nan
    try:
        return float(cell)
    except (TypeError, ValueError):
        return nan


def _check_header(
    header: Sequence[str],
    columns: Sequence[str],
    optional: Collection[str],
    *,
    others: OtherColumnsPolicy,
    required: str,
) -> None:
    """Reject a header with a column that is not known, then one that lacks a column.

    Unknown columns that would be ignored are named where another is missing: they may be that one.
    """
    for name in columns:
        if header.count(name) > 1:
            raise InputError(f"column {name!r} stands twice")
    for name in CARTESIAN_COLUMNS if POLAR_COLUMNS[0] in columns else ():
        if name in header:
            raise InputError(f"unknown column {name!r}; {POSITION_FORMS_TEXT}")
    position = (
        {*POLAR_COLUMNS, *CARTESIAN_COLUMNS}
        if POLAR_COLUMNS[0] in columns or CARTESIAN_COLUMNS[0] in columns
        else set()
    )
    factors = {*columns, *position} - {*header}
    beside = [name for name in header if name not in columns]
    missing = [name for name in columns if name not in (*header, *optional)]
    if "phi_r_m" in columns and "phi_deg" in header and "phi_r_m" not in header:
        missing.append("phi_r_m")
    halved = len(position & {*header}) == 1
    if others in ("unknown are invalid", "kept") or (others == "ignored" and (missing or halved)):
        beside = unregistered_columns(beside)
    elif others != "invalid":
        # What names a factor without its unit would be taken for a factor that is not given.
        beside = [name for name in beside if _column_and_unit_size(name)[0] in factors]
    problems = []
    for name in beside:
        own, _ = _column_and_unit_size(name)
        if own in {*columns, *position}:
            stem, _, base = own.rpartition("_")
            units = ", ".join(f"{stem}_{unit}" for unit in UNIT_SIZES_OF_BASE_UNIT[base])
            problems.append(f"column {name!r} needs a unit, one of {units}")
        else:
            near = _nearest_column(name, factors)
            problems.append(f"unknown column {name!r}" + f" (did you mean {near}?)" * bool(near))
    if problems:
        named = "; ".join(problems[:MAX_ROWS_IN_MESSAGE])
        raise InputError(f"{named}; the table needs {required}")
    for name in missing:
        form = f" ({POSITION_FORMS_TEXT})" if name in position else ""
        missed = f"column {name!r} is missing; it has {', '.join(header)}{form}"
        raise InputError(f"{missed}; the table needs {required}")


def _nearest_column(name: str, columns: Collection[str]) -> str:
    """The column that a word of a header's cell names, begins or is close to; "" if none."""
    first, *others = re.split(r"[^a-z0-9]+", name.lower())
    import difflib

    words = [each for each, own in COLUMN_OF_WORDS.items() if own in columns]
    named = [each for each in words if each in (first, *others)]
    begun = [each for each in words if len(first) > 2 and each.startswith(first)]
    close = named or begun or difflib.get_close_matches(first, words, n=1)
    if not close:
        return ""
    own = COLUMN_OF_WORDS[close[0]]
    return repr(own) + ", zero to peak" * (own == "hv_m")


def read_columns(
    path: Path | str, *, columns: Sequence[str], optional: Sequence[str] = ()
) -> pd.DataFrame:
    """Read a table that one of our commands wrote and that has at least these columns.

    Positions, named in polar form, may be in Cartesian form.

    Args:
        optional: columns that it may have, in any unit as those that it has.

    Raises InputError naming the file and the column that is missing, or a file without rows.
    """
    path, known = Path(path), (*columns, *optional)
    table, _ = _read_rows(
        path, known, optional=optional, others="ignored", required=", ".join(columns)
    )
    if path.suffix != PARQUET_SUFFIX:
        table = pd.read_csv(io.StringIO(table.to_csv(index=False)))
    return table


def write_table(table: pd.DataFrame, path: Path | str) -> None:
    """Write a table as ``table_writer`` does."""
    with table_writer(path) as write:
        write(table)


def check_parquet_installed() -> None:
    """Raise InputError where the package is missing that reads and writes Parquet."""
    with imports_from_extra("parquet", what="a table in Parquet"):
        import pyarrow  # noqa: F401


def checked_table_path(path: Path | str) -> str:
    """Return the name of a table to write.

    Raises InputError for a name that says that something else is in the file, for Parquet without
    the package that writes it, and where no file can be: before anything is computed.
    """
    suffix, folders = Path(path).suffix, Path(path).absolute().parents
    folder = next(folder for folder in folders if folder.exists())  # the rest will be made
    if not (folder.is_dir() and os.access(folder, os.W_OK)):
        raise InputError(f"{path} cannot be written: {folder} is no folder to write into")
    if suffix == PARQUET_SUFFIX:
        check_parquet_installed()
    if suffix.lower() in UNSUPPORTED_SUFFIXES:
        raise InputError(
            f"{path}: a table is written as .csv, which spreadsheets open, or as {PARQUET_SUFFIX}; "
            f"not as {suffix}"
        )
    return str(path)


@contextmanager
def table_writer(path: Path | str) -> Iterator[Callable[[pd.DataFrame], None]]:
    """Write a table piece by piece, whole or not at all: ``with table_writer(p) as write: …``.

    All pieces have the columns of the first one. CSV comes with full double precision.

    Raises InputError for a name that says that something else is in the file, ValueError for a
    column without a meaning in columns.csv.
    """
    path = Path(checked_table_path(path))
    pieces = _parquet_writer if path.suffix == PARQUET_SUFFIX else _csv_writer

    def write(piece: pd.DataFrame) -> None:
        if unknown := unregistered_columns(map(str, piece)):
            raise ValueError(f"{path}: columns.csv has no {', '.join(unknown)}")
        write_piece(piece)

    with atomic_file(path) as name, pieces(name) as write_piece:
        yield write


@contextmanager
def _csv_writer(name: Path) -> Iterator[Callable[[pd.DataFrame], None]]:
    with name.open("w", encoding="utf-8", newline="") as file:
        yield lambda piece: piece.to_csv(
            file, index=False, header=file.tell() == 0, lineterminator="\n"
        )


@contextmanager
def _parquet_writer(name: Path) -> Iterator[Callable[[pd.DataFrame], None]]:
    with imports_from_extra("parquet", what="a table in Parquet"):
        import pyarrow as pa
        import pyarrow.parquet as pq

    def column_type(column: pd.Series) -> pa.DataType:
        if column.name in TEXT_COLUMNS:
            return pa.string()
        return pa.int32() if pd.api.types.is_integer_dtype(column) else pa.float64()

    with ExitStack() as stack:
        writer: pq.ParquetWriter | None = None

        def write(piece: pd.DataFrame) -> None:
            nonlocal writer
            schema = pa.schema([(name, column_type(piece[name])) for name in piece])
            texts = {name: "str" for name in piece if name in TEXT_COLUMNS}
            rows = pa.Table.from_pandas(piece.astype(texts), schema=schema, preserve_index=False)
            # Without the notes of pandas and its version, equal tables are equal files.
            rows = rows.replace_schema_metadata(None)
            writer = writer or stack.enter_context(
                pq.ParquetWriter(name, rows.schema, compression="zstd")
            )
            writer.write_table(rows)

        yield write


def concatenate_force_parts(
    scenes: Path | str, parts: Sequence[Path | str], *, output: Path | str, keep_failed: bool
) -> None:
    """Put the forces of a plan's parts together, one part and its rows of the plan held at a time.

    Raises InputError where the parts are not the rows of the plan in its order, RunError naming the
    points without a force unless these may stay; then nothing is written.
    """
    failures: list[str] = []
    with table_writer(output) as write:
        for number, part in enumerate(parts, start=1):
            planned = read_scenes(scenes, chunk=(number, len(parts)))
            rows = read_forces(part, whole=True)
            if not planned.reset_index(drop=True).equals(rows.reindex(columns=planned.columns)):
                raise InputError(
                    f"{part}: its points are not those of part {number} of {len(parts)} of "
                    f"{scenes}; simulate it again"
                )
            failures += [f"{failure} ({part})" for failure in failed_point_texts(rows)]
            write(rows)
        if failures and not keep_failed:
            raise RunError(no_force_message(failures, scenes))


def merge_timings(parts: Sequence[Path | str], *, output: Path | str) -> None:
    """Put the run times of a plan's parts together."""
    with table_writer(output) as write:
        for part in parts:
            write(read_timings(part))


def write_json(values: dict[str, Any], path: Path | str) -> None:
    """Write a JSON file with sorted keys, whole or not at all."""
    write_text(json.dumps(values, indent=2, sort_keys=True, allow_nan=False) + "\n", path)


def read_json(path: Path | str) -> dict[str, Any]:
    """Read a JSON object.

    Raises InputError when the file is missing or not a JSON object.
    """
    text = read_text(path, what="file")
    try:
        values = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not readable as JSON: {error}") from None
    if not isinstance(values, dict):
        raise InputError(f"{path}: expected a JSON object")
    return values
