"""Tables in Markdown, for people to read."""

from collections.abc import Sequence
from typing import Any

import pandas as pd


def markdown_table(table: pd.DataFrame) -> str:
    """The table in Markdown; values are shown as they are, missing ones as a dash."""
    return markdown_rows([list(table.columns), *table.to_numpy().tolist()])


def markdown_rows(rows: Sequence[Sequence[Any]]) -> str:
    """Rows of cells as a table in Markdown, the first one as its header."""
    header, *others = rows
    shown = [["–" if pd.isna(cell) else cell for cell in row] for row in others]
    return "".join(
        "| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |\n"
        for row in [header, ["---"] * len(header), *shown]
    )
