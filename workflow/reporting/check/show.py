"""The table of a check, for the screen and as Markdown."""

from pathlib import Path

import pandas as pd

from reporting.check.compare import COLUMNS, PASSED
from squeezefilm.io.errors import InputError
from squeezefilm.io.markdown import markdown_table

WIDTHS = {
    "item": 44,
    "quantity": 30,
    "expected": 18,
    "got": 18,
    "tolerance": 32,
    "verdict": 7,
    "worst": 24,
}
SHOWN = tuple(WIDTHS)


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


def condensed(table: pd.DataFrame) -> pd.DataFrame:
    """For each item the quantities that failed or, where none did, the one nearest to it."""
    # Limits are kept or not; how nearly says less than how far a number has moved.
    rank = table["of_tolerance"].where(~table["tolerance"].str.startswith("at most"), -1.0)
    ranked = table.assign(rank=rank, order=range(len(table))).sort_values(["rank", "order"])
    items = table.groupby(["part", "item"], sort=False)
    nearest = ranked.drop_duplicates(["part", "item"], keep="last").index
    failed = table["verdict"] != PASSED
    has_failed = failed.groupby([table["part"], table["item"]]).transform("any")
    shown = table[failed | (~has_failed & table.index.isin(nearest))]
    counts = items["quantity"].transform("size")
    return shown.assign(
        item=shown["part"] + ": " + shown["item"],
        quantity=[
            f"{name} (worst of {count})" if verdict == PASSED and count > 1 else name
            for name, count, verdict in zip(
                shown["quantity"], counts[shown.index], shown["verdict"], strict=True
            )
        ],
    )[list(SHOWN)]


def on_screen(table: pd.DataFrame) -> str:
    """The condensed table in columns, long cells cut, and the summary below."""
    shown = condensed(table)
    lines = [list(SHOWN), *shown.astype(str).to_numpy().tolist()]
    text = [
        "  ".join(_cut(cell, WIDTHS[name]) for name, cell in zip(SHOWN, line, strict=True)).rstrip()
        for line in lines
    ]
    return "\n".join([*text, "", summary(table)])


def _cut(text: str, width: int) -> str:
    return f"{text:{width}}" if len(text) <= width else f"{text[: width - 1]}…"


def to_markdown(table: pd.DataFrame) -> str:
    """The summary, and every quantity."""
    shown = table.assign(of_tolerance=table["of_tolerance"].map("{:.2g}".format))
    return f"{summary(table)}\n\n{markdown_table(shown)}"
