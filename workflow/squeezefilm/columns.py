"""The registry of columns, columns.csv: what each column is, its unit, and how it is shown."""

import csv
from collections.abc import Container, Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

from squeezefilm.units import split_unit, unit_size


class Column(NamedTuple):
    """A column that a table may have; ``*`` in its name stands for any text.

    Attributes:
        unit: as its name ends, 1 for a plain number, ``text`` or ``bool``.
        table_names: the tables that have it.
        label: its name in lines for people without the unit, where ``name`` itself is none.
        symbol: its symbol in LaTeX.
        shown_unit: the unit in which figures and sentences have it.
        of: the output that it is of, or the number that the force is differentiated to.
    """

    name: str
    unit: str
    meaning: str
    table_names: str
    label: str
    symbol: str = ""
    shown_unit: str = ""
    of: str = ""

    @property
    def text_symbol(self) -> str:
        """The symbol without LaTeX."""
        return self.symbol.replace(r"\phi_\varphi", "φ").replace(r"\phi_r", "r").replace("_", "")

    @property
    def title(self) -> str:
        """The label and the symbol in LaTeX, for axes of figures."""
        words = self.label.removesuffix(f" {self.text_symbol}")
        return f"{words} ${self.symbol}$" if self.symbol else words

    def in_shown_unit(self, values: Any) -> Any:
        """Values in the shown unit, or in the column's own."""
        if not self.shown_unit:
            return values
        return values / unit_size(self.shown_unit, of=self.unit)


_COLUMNS_CSV_LINES = (
    Path(__file__).with_name("columns.csv").read_text(encoding="utf-8").splitlines()
)
COLUMNS = {row[0]: Column(*row) for row in csv.reader(_COLUMNS_CSV_LINES[1:])}
"""Every column that the commands and the workflow write, by name."""
COLUMN_NAME_PATTERNS = [name for name in COLUMNS if "*" in name]
TEXT_COLUMNS = {column.name for column in COLUMNS.values() if column.unit == "text"}
FORCE_ERROR_COLUMNS = ("error_95_n", "error_99_n", "measurement_noise_n")
"""Columns of errors that are those of a force without its name."""


def unregistered_columns(names: Iterable[str]) -> list[str]:
    """Return the columns that COLUMNS does not list."""
    others = [name for name in names if name not in COLUMNS]
    return [
        name
        for name in others
        if not any(fnmatchcase(name, pattern) for pattern in COLUMN_NAME_PATTERNS)
    ]


def error_column(name: str, kind: str = "error") -> str:
    """Return the column of a value's error: ``h0_error_m`` of ``h0_m``."""
    quantity, unit = split_unit(name)
    return "_".join(filter(None, (quantity, kind, unit)))


def error_columns(name: str, names: Container[str]) -> list[str]:
    """The columns of a value's errors among those of a table."""
    known = [error_column(name, kind) for kind in ("error", "error_95", "measurement_noise")]
    known += [*FORCE_ERROR_COLUMNS] * (name == "force_n")
    return [column for column in known if column in names]
