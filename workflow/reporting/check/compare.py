"""Quantities beside their references: one table with a verdict for each."""

import csv
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from reporting.check.quantities import PICTURES, Quantity, pictures_of, write_pictures
from reporting.check.tolerances import SAME, Cells
from squeezefilm.errors import InputError
from squeezefilm.tables import write_table

PASSED, FAILED = "passed", "failed"
COLUMNS = (
    *("part", "item", "quantity", "expected", "got", "tolerance", "verdict", "worst"),
    "of_tolerance",
)
"""``worst`` names the cell that is farthest off, ``expected`` and ``got`` are its two values,
``of_tolerance`` is how much of the tolerance it takes."""
REFERENCE_COLUMNS = ("item", "quantity", "cell", "value")
WIDEST = 40
"""Characters of a cell on the screen; all of it is in the table."""

Key = tuple[str, str, str]
Reference = dict[Key, dict[str, str]]
"""The cells of every quantity, by part, item and name."""


def compare(found: Iterable[Quantity], reference: Mapping[Key, Cells]) -> pd.DataFrame:
    """A row for every quantity found, then one for each that the reference has and the study lacks.

    A quantity that the reference does not have fails as well: it was never reviewed.
    """
    rows, seen, unreadable = [], set(), set()
    for quantity in found:
        seen.add(quantity.key)
        if quantity.missing:
            unreadable.add(quantity.key[:2])
            rows.append(_failed(quantity.key, "a file", quantity.missing))
        elif quantity.key not in reference:
            rows.append(_failed(quantity.key, "not in the reference", "found"))
        else:
            rows.append(_judged(quantity, reference[quantity.key]))
    rows += [
        _failed(key, "as in the reference", "missing")
        for key in reference
        if key not in seen and key[:2] not in unreadable
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _judged(quantity: Quantity, expected: Cells) -> tuple[Any, ...]:
    got = quantity.cells
    if list(expected) != list(got):
        odd = next(iter(set(expected) ^ set(got)), "another order")
        return _failed(quantity.key, f"{len(expected)} cells", f"{len(got)} cells", odd)
    worst = quantity.tolerance.worst(expected, got)
    values = (expected.get(worst.cell, "1"), worst.got or got[worst.cell])
    verdict = PASSED if worst.distance <= 1 else FAILED
    about = (str(quantity.tolerance), verdict, worst.cell, worst.distance)
    return (*quantity.key, *values, *about)


def _failed(key: Key, expected: str, got: str, worst: str = "") -> tuple[Any, ...]:
    return (*key, expected, got, str(SAME), FAILED, worst, math.inf)


def read_reference(folder: Path) -> Reference:
    """Read the cells of every quantity, one file for each part.

    Raises InputError where there is no reference, or a file of it that is none.
    """
    paths = sorted(folder.glob("*.csv"))
    if not paths:
        raise InputError(f"{folder}: there is no reference; `make reference` makes one")
    reference: Reference = {}
    for path in paths:
        with path.open(newline="", encoding="utf-8") as handle:
            rows = csv.reader(handle)
            if tuple(next(rows, ())) != REFERENCE_COLUMNS:
                raise InputError(f"{path}: the columns must be {', '.join(REFERENCE_COLUMNS)}")
            for line, row in enumerate(rows, start=2):
                if len(row) != len(REFERENCE_COLUMNS):
                    raise InputError(f"{path}: line {line}: {len(row)} cells, not 4")
                item, quantity, cell, value = row
                reference.setdefault((_part(path), item, quantity), {})[cell] = value
    return reference | pictures_of(folder)


def write_reference(quantities: Iterable[Quantity], results: Path, folder: Path) -> None:
    """Write a study's quantities and pictures, and remove the files of parts that are gone.

    Raises InputError where a result is missing, or a file cannot be written.
    """
    parts: dict[str, list[tuple[str, ...]]] = {}
    for quantity in quantities:
        if quantity.missing:
            raise InputError(f"a reference needs a finished study: {quantity.missing}")
        if quantity.part != PICTURES:
            rows = parts.setdefault(quantity.part, [])
            rows += [(quantity.item, quantity.name, *cell) for cell in quantity.cells.items()]
    for part, rows in parts.items():
        path = folder / f"{part.replace(' ', '_')}.csv"
        write_table(pd.DataFrame(rows, columns=list(REFERENCE_COLUMNS)), path)
    for path in folder.glob("*.csv"):
        if _part(path) not in parts:
            path.unlink()
    write_pictures(results, folder)


def differences(found: Iterable[Quantity], reference: Mapping[Key, Cells]) -> list[str]:
    """What a new reference would change, cell by cell, however small."""
    old = {(*key, cell): value for key, cells in reference.items() for cell, value in cells.items()}
    new = {
        (*quantity.key, cell): value for quantity in found for cell, value in quantity.cells.items()
    }
    return [
        f"{', '.join(place)}: {old.get(place, '–')} → {new.get(place, '–')}"
        for place in dict.fromkeys([*old, *new])
        if old.get(place) != new.get(place)
    ]


def _part(path: Path) -> str:
    return path.stem.replace("_", " ")


def summary(table: pd.DataFrame) -> str:
    """How many quantities passed, in a sentence."""
    failed = int((table["verdict"] != PASSED).sum())
    if failed:
        return f"{failed} of {len(table)} quantities failed."
    return f"All {len(table)} quantities passed."


def on_screen(table: pd.DataFrame) -> str:
    """Return each part's worst quantity, all that failed, and the summary."""
    failed = table["verdict"] != PASSED
    # A limit is kept or not; how nearly says less than how far a number has moved.
    moved = table["of_tolerance"].where(~table["tolerance"].str.startswith("at most"), 0.0)
    worst = table.loc[moved.groupby(table["part"], sort=False).idxmax()]
    kinds = {"Worst of each part": worst[["part", "item", "quantity", "of_tolerance"]]}
    if failed.any():
        kinds["Failed"] = table[failed]
    how: dict[str, Any] = {"index": False, "max_colwidth": WIDEST, "float_format": "{:.2g}".format}
    shown = [f"{title}:\n{rows.to_string(**how)}\n\n" for title, rows in kinds.items()]
    return "".join([*shown, summary(table)])
