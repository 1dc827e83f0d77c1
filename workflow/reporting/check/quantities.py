"""What a finished study is checked by: every quantity with its place, its numbers, its tolerance.

The order is that of the table: settings; figures' data and the paper's tables; claims; simulations,
fits and designs; pictures; numerics. Figures stand before what they are made from, for they are
what a reviewer looks at.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reporting.check.tolerances import SAME, Close, Tolerance
from squeezefilm.io.errors import InputError

SAMPLE = 25
"""Rows of a table that a reference keeps; least, mean and largest stand for the others."""


@dataclass(frozen=True)
class Quantity:
    """One column, list or text of a study: its cells by name, as text, and how close they must be.

    part and item say where it belongs: figure data, fig08. There is at least one cell, but for a
    missing file, which is a Quantity as well, with its name in ``missing``.
    """

    part: str
    item: str
    name: str
    cells: Mapping[str, str] = field(default_factory=dict)
    tolerance: Tolerance = SAME
    missing: str = ""


def text_of(value: Any) -> str:
    """A cell's text: twelve digits of a number, so that 7e-06 reads so."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.number):
        return str(value)
    return f"{float(value):.12g}"


def guarded(part: str, item: str, make: Callable[[], Iterator[Quantity]]) -> Iterator[Quantity]:
    """The quantities of an item, or that a file of it is missing or cannot be read."""
    try:
        yield from list(make())
    except InputError as error:
        yield Quantity(part, item, "readable", missing=str(error))


def column_quantities(
    part: str,
    item: str,
    table: pd.DataFrame,
    *,
    tolerances: Mapping[str, Tolerance],
) -> Iterator[Quantity]:
    """A table's number of rows, then its columns thinned out; a column without tolerance is text.

    Of a longer table, SAMPLE rows evenly spaced are kept, and of its columns of numbers the
    least, the mean and the largest value.
    """
    yield Quantity(part, item, "rows", {"rows": str(len(table))})
    kept = sorted({round(row) for row in np.linspace(0, len(table) - 1, SAMPLE)})
    for name in table.columns:
        column = table[name]
        cells = {f"row {row + 1}": text_of(column.iloc[row]) for row in kept}
        tolerance = tolerances.get(str(name), SAME)
        if isinstance(tolerance, Close) and len(table) > len(kept):
            numbers = column.astype(float)
            cells |= {
                "least": text_of(numbers.min()),
                "mean": text_of(numbers.mean()),
                "largest": text_of(numbers.max()),
            }
        yield Quantity(part, item, str(name), cells, tolerance)


def by_name(folder: Path, pattern: str) -> list[str]:
    """The stems of the files that match, sorted."""
    return sorted(path.stem for path in folder.glob(pattern))
