"""The tables that pass between the stages: their columns, and reading with checks.

A table is CSV, or Parquet where its file name ends in ``.parquet``: for plans so large that text
would take longer to read than scenes to solve.
"""

from __future__ import annotations

import io
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from squeezefilm.columns import COLUMNS, TEXT_COLUMNS, unregistered_columns
from squeezefilm.errors import (
    MAX_ROWS_IN_MESSAGE,
    InputError,
    imports_from_extra,
    point_text,
    prefix_errors,
    raise_row_problems,
)
from squeezefilm.film.positions import (
    CARTESIAN_COLUMNS,
    POLAR_COLUMNS,
    columns_in_table_form,
    fill_missing_coordinate,
)
from squeezefilm.lazy import pd
from squeezefilm.solution import SOLUTION_COLUMNS
from squeezefilm.text_tables.cells import (
    is_number,
    number_of_cell,
    number_text,
    without_units_and_thousands,
)
from squeezefilm.text_tables.header import (
    COMMENT_PATTERN,
    ROW_NAMES,
    Column,
    find_header,
    no_header_text,
    rows_of_lines,
)
from squeezefilm.text_tables.scene_header import (
    COLUMN_OF_WORDS,
    DEVIATION_WORDS,
    UNIT_SIZES_OF_BASE_UNIT,
    SceneVocabulary,
    column_and_unit,
    is_peak_to_peak,
    words_and_unit,
)

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
PARQUET_SUFFIX = ".parquet"
FORCE_COLUMNS = (*SCENE_COLUMNS, *SOLUTION_COLUMNS)
"""Of forces; derivatives and outputs stand behind them."""
OPTIONAL_FORCE_COLUMNS = {*SOLUTION_COLUMNS} - {
    "force_n",
    "force_error_n",
    "status",
    "absent_terms",
}
"""Columns of forces that a table may lack."""
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
            raise InputError(f"{path}: {point_text(bad.iloc[0])}: {name} is not a finite number")
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
    return [f"{point_text(row.point_id)}: {row.status}" for row in failed.itertuples()]


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
    for name in [column for column in columns_in_table_form(numbers, wanted) if column in wanted]:
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
    uncertain: list[str] = []
    if path.suffix == PARQUET_SUFFIX:
        table, lines = _read_parquet_rows(path, chunk=chunk)
    else:
        table, lines, uncertain = _read_csv_rows(path, columns=columns, required=required)
    header = list(map(str, table))
    with prefix_errors(path):
        asked = columns_in_table_form(columns, header)
        optional = [*optional, *columns_in_table_form(optional, header)]
        problems = _uncertain_cells_problem(uncertain, columns)
        _check_header(header, asked, optional, others=others, required=required, problems=problems)
    if not lines:
        raise InputError(f"{path}: the table has a header and no rows")
    return table, lines


def _read_csv_rows(
    path: Path, *, columns: Iterable[str], required: str
) -> tuple[pd.DataFrame, list[int], list[str]]:
    """Rows as text, the line of each, and the columns whose cells have uncertainties."""
    from squeezefilm.text_tables.text_file import read_table_lines  # as long as a small film

    vocabulary = SceneVocabulary(_asked_columns(columns))
    with prefix_errors(path):
        lines, _ = read_table_lines(path, what="table", form=required)
        header = find_header(lines, vocabulary, what="table", form=required)
        rows = rows_of_lines(lines[header.first_row :], header.separator, start=header.first_row)
        if not header.is_known and any(map(is_number, header.names)):
            raise InputError(no_header_text(header, lines, form=required))
    names = [*header.names]
    if names[0] in ("", ROW_NAMES) and "point_id" not in names:  # as pandas writes rows' names
        names[0] = "point_id"
    width = max(at for at, name in enumerate(names, start=1) if name)
    for _, cells in rows:
        if not any(cells[width:]):
            del cells[width:]
    # A row's name may begin with the sign.
    rows = [row for row in rows if len(row[1]) == width or not COMMENT_PATTERN.match(row[1][0])]
    problems = [
        f"{path}: line {line}: {len(cells)} cells where the header has {width}"
        for line, cells in rows
        if len(cells) != width
    ]
    raise_row_problems(problems if header.is_known else [])
    rows = [] if problems else rows  # then a message on the columns comes first
    numbers = [line for line, _ in rows]
    table = pd.DataFrame([cells for _, cells in rows], numbers, names[:width], dtype="str")
    uncertain = (
        [
            str(name)
            for name, cells in table.items()
            if name not in TEXT_COLUMNS and cells.str.contains(r"\d±").any()
        ]
        if any("±" in line or "+/-" in line for line in lines)
        else []
    )
    with prefix_errors(path):
        table = _columns_in_si(table, vocabulary, header.separator)
    return table.reset_index(drop=True), numbers, uncertain


def _uncertain_cells_problem(names: Sequence[str], columns: Sequence[str]) -> list[str]:
    """The problem of columns whose cells have uncertainties, if there are any."""
    may_have = {*columns} & {*MEASUREMENT_UNCERTAINTY_COLUMNS}
    remedy = "write standard ones into columns of their own" if may_have else "delete these"
    named = ", ".join(map(repr, names))
    return [f"cells of {named} have uncertainties behind ±; {remedy}"] * bool(names)


def _columns_in_si(
    table: pd.DataFrame, vocabulary: SceneVocabulary, separator: str
) -> pd.DataFrame:
    """Columns under their own names, their numbers as texts in SI units; ``attrs`` has the names
    that they had, for messages."""
    header = list(map(str, table))
    known = vocabulary.sized_columns(header)
    names = [known[at].quantity if at in known else name for at, name in enumerate(header)]
    columns = dict(enumerate(table.iloc[:, at] for at in range(len(header))))
    numbers = {
        at: known.get(at, Column(name, "", 1.0, at, name))
        for at, name in enumerate(names)
        if name not in TEXT_COLUMNS and (at in known or name in COLUMNS)
    }
    plain = without_units_and_thousands(
        [(column.name, column.unit, columns[at]) for at, column in numbers.items()], separator
    )
    for (at, column), cells in zip(numbers.items(), plain, strict=True):
        if column.size != 1 or cells is not columns[at]:
            columns[at] = cells.map(partial(_cell_in_si, size=column.size or 1.0))
    table = pd.concat(columns, axis=1).set_axis(names, axis=1)
    table.attrs = dict(zip(names, header, strict=True))
    return table


def _asked_columns(columns: Iterable[str]) -> set[str]:
    """Columns in either form of a position."""
    columns = list(columns)
    return {
        *columns_in_table_form(columns, ()),
        *columns_in_table_form(columns, CARTESIAN_COLUMNS),
    }


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
    vocabulary = SceneVocabulary(_asked_columns(FACTOR_COLUMNS))
    renamed = {
        column.name: column
        for column in vocabulary.sized_columns(names).values()
        if column.name != column.quantity
    }
    if renamed:
        table = points if isinstance(points, pd.DataFrame) else pd.DataFrame(points)
        scaled = {
            name: [float(f"{number_of_cell(cell) * column.size:.15g}") for cell in table[name]]
            for name, column in renamed.items()
            if column.size
        }
        own_names = {name: column.quantity for name, column in renamed.items()}
        points = table.assign(**scaled).rename(columns=own_names)
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


def _cell_in_si(cell: str, size: float) -> str:
    """Return the number in a cell times the size of its unit, the cell where there is none."""
    cell = number_text(cell)
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


def _check_header(
    header: Sequence[str],
    columns: Sequence[str],
    optional: Collection[str],
    *,
    others: OtherColumnsPolicy,
    required: str,
    problems: Sequence[str] = (),
) -> None:
    """Reject a header with a column that is not known, then one that lacks a column.

    Unknown columns that would be ignored are named where another is missing: they may be that one.

    Args:
        problems: of the rows, to be told in the same message.
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
        beside = [name for name in beside if column_and_unit(name)[0] in factors]
    told, suggested = [], set[str]()
    for name in beside:
        own, *_ = column_and_unit(name)
        if own in {*columns, *position}:
            stem, _, base = own.rpartition("_")
            units = ", ".join(f"{stem}_{unit}" for unit in UNIT_SIZES_OF_BASE_UNIT[base])
            told.append(f"column {name!r} needs a unit, one of {units}")
        else:
            likely = _likely_column(name, factors, missing={*missing} - suggested)
            suggested.add(likely)
            told.append(f"unknown column {name!r}" + _suggestion_text(name, likely) * bool(likely))
    if told or problems:
        named = "; ".join([*told[:MAX_ROWS_IN_MESSAGE], *problems])
        raise InputError(
            f"{named}; the table needs {required}" + "; delete other columns" * bool(told)
        )
    for name in missing:
        form = f" ({POSITION_FORMS_TEXT})" if name in position else ""
        missed = f"column {name!r} is missing; it has {', '.join(header)}{form}"
        raise InputError(f"{missed}; the table needs {required}")


def _likely_column(name: str, columns: Collection[str], *, missing: Collection[str]) -> str:
    """The column that a word of a header's cell names, begins or is close to; "" if none.

    Where words do not tell, that of the unit, a ``missing`` one first.
    """
    import difflib  # only needed here

    first, *others = re.split(r"[^a-z0-9]+", name.lower())
    words = [word for word, own in COLUMN_OF_WORDS.items() if own in columns]
    named = [word for word in words if word in (first, *others)]
    begun = [word for word in words if len(first) > 2 and word.startswith(first)]
    close = named or begun or difflib.get_close_matches(first, words, n=1)
    if close:
        return COLUMN_OF_WORDS[close[0]]
    own_words, unit = words_and_unit(name)
    of_unit = [
        column
        for column in columns
        if unit in UNIT_SIZES_OF_BASE_UNIT.get(column.rpartition("_")[2], {})
    ]
    is_deviation = bool({*own_words} & DEVIATION_WORDS)
    likely = [
        column
        for column in of_unit
        if column in missing and ("uncertainty" in column) == is_deviation
    ]
    of_unit = of_unit if len(of_unit) == 1 else likely
    return of_unit[0] if len(of_unit) == 1 else ""


def _suggestion_text(name: str, column: str) -> str:
    """The question whether a header's cell is a column, in the unit that it has."""
    words, unit = words_and_unit(name)
    stem, _, base = column.rpartition("_")
    called = f"{stem}_{unit}" if unit in UNIT_SIZES_OF_BASE_UNIT.get(base, {}) else column
    kind = ", the standard one" * ("uncertainty" in column)
    if column == "hv_m":
        kind = ", zero to peak" + ", half of peak to peak" * is_peak_to_peak(words)
    return f" (did you mean {called!r}{kind}?)"


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
