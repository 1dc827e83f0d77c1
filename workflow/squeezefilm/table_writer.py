"""Writing tables that pass between the stages, whole or not at all, and joining their parts."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from squeezefilm.columns import TEXT_COLUMNS, unregistered_columns
from squeezefilm.errors import InputError, RunError, imports_from_extra
from squeezefilm.files import atomic_file
from squeezefilm.lazy import pd
from squeezefilm.tables import (
    PARQUET_SUFFIX,
    failed_point_texts,
    no_force_message,
    read_forces,
    read_scenes,
    read_timings,
)

UNSUPPORTED_SUFFIXES = {".xlsx", ".xls", ".ods", ".json", ".feather", ".h5", ".hdf5", ".mat", ".nc"}
"""Names of files that are expected to hold something else than text in columns."""


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
    if str(path) == "-":
        raise InputError("-: a table is written to a file; give its name")
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
