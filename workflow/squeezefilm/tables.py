"""The tables that pass between the stages: their columns, reading with checks, writing."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
import pandas as pd

from squeezefilm.errors import InputError

FACTOR_COLUMNS = ("h0_m", "hv_m", "phi_r_m", "phi_deg")
SCENE_COLUMNS = ("point_id", *FACTOR_COLUMNS)
FORCE_COLUMNS = (
    *SCENE_COLUMNS,
    "force_n",
    "force_error_n",
    "status",
    "method",
    "left_out",
    "nx",
    "ny",
    "nt",
    "newton_steps",
    "krylov_iterations",
    "residual",
)


@dataclass(frozen=True)
class ScenePoint:
    """One row of a plan: gap, amplitude and finger position."""

    point_id: str
    h0_m: float
    hv_m: float
    phi_r_m: float
    phi_deg: float


def read_scenes(path: Path | str) -> pd.DataFrame:
    """Read a plan: ``point_id`` as text, the four factors as finite numbers, order kept.

    Raises:
        InputError: naming the file, the row or the column that is wrong.
    """
    return _read(path, columns=SCENE_COLUMNS, numbers=FACTOR_COLUMNS)


def read_forces(path: Path | str) -> pd.DataFrame:
    """Read simulated forces; a row whose status is not ``ok`` may lack its force.

    Raises:
        InputError: naming the file, the row or the column that is wrong.
    """
    table = _read(path, columns=FORCE_COLUMNS, numbers=FACTOR_COLUMNS)
    for name in ("force_n", "force_error_n"):
        values = pd.to_numeric(table[name], errors="coerce")
        bad = (table["status"] == "ok") & ~np.isfinite(values)
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            raise InputError(f"{path}: row {row + 2}: {name} is not a finite number")
        table[name] = values
    return table


def read_ok_forces(path: Path | str) -> pd.DataFrame:
    """Read simulated forces of which every one is needed.

    Raises:
        InputError: naming the points that were not solved.
    """
    table = read_forces(path)
    failed = table[table["status"] != "ok"]
    if len(failed):
        names = "; ".join(f"point {row.point_id}: {row.status}" for row in failed.itertuples())
        raise InputError(f"{path}: no force for {names}")
    return table


def scene_points(table: pd.DataFrame) -> list[ScenePoint]:
    """The rows of a plan as points."""
    return [
        ScenePoint(str(row.point_id), row.h0_m, row.hv_m, row.phi_r_m, row.phi_deg)
        for row in table.itertuples()
    ]


def _read(path: Path | str, *, columns: Sequence[str], numbers: Sequence[str]) -> pd.DataFrame:
    path = Path(path)
    try:
        raw = pd.read_csv(path, header=None, dtype=str, keep_default_na=False, encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such table") from None
    except pd.errors.EmptyDataError:
        raise InputError(f"{path}: the table is empty; it needs {', '.join(columns)}") from None
    except (OSError, UnicodeDecodeError, pd.errors.ParserError) as error:
        raise InputError(f"{path}: the table cannot be read: {error}") from None
    header = [name.strip() for name in raw.iloc[0]]
    for name in columns:
        if header.count(name) == 0:
            raise InputError(f"{path}: column {name!r} is missing; it has {', '.join(header)}")
        if header.count(name) > 1:
            raise InputError(f"{path}: column {name!r} stands twice")
    unknown = [name for name in header if name not in columns]
    if unknown:
        raise InputError(
            f"{path}: unknown column {unknown[0]!r}; the columns are {', '.join(columns)}"
        )
    table = raw.iloc[1:].reset_index(drop=True)
    table.columns = pd.Index(header)
    if table.empty:
        raise InputError(f"{path}: the table has a header and no rows")
    for name in numbers:
        table[name] = _finite(table[name], path=path, name=name)
    table["point_id"] = table["point_id"].str.strip()
    if (table["point_id"] == "").any():
        row = int(np.flatnonzero(table["point_id"] == "")[0])
        raise InputError(f"{path}: row {row + 2}: point_id is empty")
    twice = table["point_id"][table["point_id"].duplicated()]
    if len(twice):
        raise InputError(f"{path}: row {twice.index[0] + 2}: point_id {twice.iloc[0]!r} stands twice")
    return table


def _finite(column: pd.Series, *, path: Path, name: str) -> pd.Series:
    values = pd.to_numeric(column, errors="coerce").astype(float)
    bad = ~np.isfinite(values)
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        raise InputError(
            f"{path}: row {row + 2}: {name} is {column.iloc[row]!r}, not a finite number"
        )
    return values


def write_table(table: pd.DataFrame, path: Path | str) -> None:
    """Write a CSV with full double precision, whole or not at all."""
    _write_whole(Path(path), lambda handle: table.to_csv(handle, index=False, lineterminator="\n"))


def write_json(values: dict[str, Any], path: Path | str) -> None:
    """Write a JSON file with sorted keys, whole or not at all."""
    text = json.dumps(values, indent=2, sort_keys=True, allow_nan=False) + "\n"
    _write_whole(Path(path), lambda handle: handle.write(text))


def read_json(path: Path | str) -> dict[str, Any]:
    """Read a JSON object.

    Raises:
        InputError: when the file is missing or not a JSON object.
    """
    try:
        values = json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise InputError(f"{path}: not readable as JSON: {error}") from None
    if not isinstance(values, dict):
        raise InputError(f"{path}: expected a JSON object")
    return values


def _write_whole(path: Path, write: Callable[[IO[str]], Any]) -> None:
    """Write beside the target and rename, so that no half-written file bears its name."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as handle:
            write(handle)
        os.chmod(name, 0o644)
        os.replace(name, path)
    except OSError as error:
        Path(name).unlink(missing_ok=True)
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
