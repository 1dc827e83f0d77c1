"""The table of a check, for the screen and as Markdown."""

from pathlib import Path
from typing import Any

import pandas as pd

from reporting.check.compare import COLUMNS, PASSED
from squeezefilm.io.errors import InputError
from squeezefilm.io.markdown import markdown_table

WIDEST = 40
"""Characters of a cell on the screen; all of it is in the table."""


def read_check(path: Path) -> pd.DataFrame:
    """Read the table of a check.

    Raises InputError for a file that is none.
    """
    try:
        table = pd.read_csv(path, dtype=str, keep_default_na=False)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: the table cannot be read: {error}") from None
    if tuple(table.columns) != COLUMNS or table.empty:
        raise InputError(f"{path}: a check has rows and the columns {', '.join(COLUMNS)}")
    return table.assign(of_tolerance=table["of_tolerance"].astype(float))


def status(table: pd.DataFrame) -> int:
    """The exit status: 1 when anything failed."""
    return int((table["verdict"] != PASSED).any())


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


def to_markdown(table: pd.DataFrame) -> str:
    """The summary, and every quantity."""
    shown = table.assign(of_tolerance=table["of_tolerance"].map("{:.2g}".format))
    return f"{summary(table)}\n\n{markdown_table(shown)}"
