"""References: small stored tables of a study's quantities, one file for each part."""

import csv
from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from reporting.check.compare import Judgement, Key, Reference
from reporting.check.pictures import PICTURES, expected_pictures
from reporting.check.quantities import Quantity
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import write_table

COLUMNS = ("item", "quantity", "cell", "value")


def read_reference(folder: Path) -> dict[Key, dict[str, str]]:
    """Read the cells of every quantity.

    Raises InputError where there is no reference, or a file of it that is none.
    """
    paths = sorted(folder.glob("*.csv"))
    if not paths:
        raise InputError(f"{folder}: there is no reference; `make reference` makes one")
    reference: dict[Key, dict[str, str]] = {}
    for path in paths:
        with path.open(newline="", encoding="utf-8") as handle:
            rows = csv.reader(handle)
            if tuple(next(rows, ())) != COLUMNS:
                raise InputError(f"{path}: the columns must be {', '.join(COLUMNS)}")
            for line, row in enumerate(rows, start=2):
                if len(row) != len(COLUMNS):
                    raise InputError(f"{path}: line {line}: {len(row)} cells, not {len(COLUMNS)}")
                item, quantity, cell, value = row
                reference.setdefault((_part(path), item, quantity), {})[cell] = value
    return reference | expected_pictures(folder)


def write_reference(quantities: Iterable[Quantity], folder: Path) -> None:
    """Write a study's quantities, and remove the files of parts that it no longer has.

    Raises InputError where a result is missing, or a file cannot be written.
    """
    parts: dict[str, list[tuple[str, str, str, str]]] = {}
    for quantity in quantities:
        if quantity.missing:
            raise InputError(f"a reference needs a finished study: {quantity.missing}")
        if quantity.part == PICTURES:
            continue
        parts.setdefault(quantity.part, []).extend(
            (quantity.item, quantity.name, cell, value) for cell, value in quantity.cells.items()
        )
    for part, rows in parts.items():
        write_table(pd.DataFrame(rows, columns=list(COLUMNS)), folder / f"{_stem(part)}.csv")
    for path in folder.glob("*.csv"):
        if _part(path) not in parts:
            path.unlink()


def differences(found: Iterable[Quantity], reference: Reference) -> list[Judgement]:
    """What a new reference would change, cell by cell, however small."""
    changed = []
    old = {(*key, cell): value for key, cells in reference.items() for cell, value in cells.items()}
    new = {
        (quantity.part, quantity.item, quantity.name, cell): value
        for quantity in found
        for cell, value in quantity.cells.items()
    }
    for place in dict.fromkeys([*old, *new]):
        part, item, name, cell = place
        before, after = old.get(place, "–"), new.get(place, "–")
        if before != after:
            changed.append(Judgement(part, item, name, before, after, "", "changes", cell))
    return changed


def _stem(part: str) -> str:
    return part.replace(" ", "_")


def _part(path: Path) -> str:
    return path.stem.replace("_", " ")
