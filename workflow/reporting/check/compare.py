"""Quantities beside their references: one table with a verdict for each."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import astuple, dataclass, fields

import pandas as pd

from reporting.check.quantities import Quantity
from reporting.check.tolerances import SAME, Cells

PASSED, FAILED = "passed", "failed"

Key = tuple[str, str, str]
Reference = Mapping[Key, Cells]
"""The cells of every quantity, by part, item and name."""


@dataclass(frozen=True)
class Judgement:
    """One row of the table.

    worst names the cell that is farthest off, expected and got are its two values, of_tolerance
    says how much of the tolerance it takes.
    """

    part: str
    item: str
    quantity: str
    expected: str
    got: str
    tolerance: str
    verdict: str
    worst: str
    of_tolerance: float = 0.0


COLUMNS = tuple(each.name for each in fields(Judgement))


def compare(found: Iterable[Quantity], reference: Reference) -> list[Judgement]:
    """A row for every quantity found, then one for each that the reference has and the study lacks.

    A quantity that the reference does not have fails as well: it was never reviewed.
    """
    rows, seen = [], set()
    unreadable = set()
    for quantity in found:
        key = (quantity.part, quantity.item, quantity.name)
        seen.add(key)
        if quantity.missing:
            unreadable.add((quantity.part, quantity.item))
            rows.append(_failed(key, expected="a file", got=quantity.missing))
        elif key not in reference:
            rows.append(_failed(key, expected="not in the reference", got="found"))
        else:
            rows.append(_judge(quantity, reference[key]))
    rows += [
        _failed(key, expected="as in the reference", got="missing")
        for key in reference
        if key not in seen and key[:2] not in unreadable
    ]
    return rows


def _judge(quantity: Quantity, expected: Cells) -> Judgement:
    key = (quantity.part, quantity.item, quantity.name)
    got, tolerance = quantity.cells, quantity.tolerance
    if list(expected) != list(got):
        odd = next(iter(_unshared(expected, got)), "another order")
        return _failed(key, expected=f"{len(expected)} cells", got=f"{len(got)} cells", worst=odd)
    worst = tolerance.worst(expected, got)
    shown = worst.shown or (expected[worst.cell], got[worst.cell])
    verdict = PASSED if worst.distance <= 1 else FAILED
    return Judgement(*key, *shown, str(tolerance), verdict, worst.cell, worst.distance)


def _unshared(expected: Cells, got: Cells) -> Iterator[str]:
    yield from (cell for cell in expected if cell not in got)
    yield from (cell for cell in got if cell not in expected)


def _failed(key: Key, *, expected: str, got: str, worst: str = "") -> Judgement:
    return Judgement(*key, expected, got, str(SAME), FAILED, worst, math.inf)


def to_table(rows: Iterable[Judgement]) -> pd.DataFrame:
    """The rows as a table, columns COLUMNS."""
    return pd.DataFrame([astuple(row) for row in rows], columns=list(COLUMNS))
