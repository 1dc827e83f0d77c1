"""Tables in Markdown, for people to read."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from squeezefilm.errors import InputError


def markdown_table(table: pd.DataFrame) -> str:
    """The table in Markdown; values are shown as they are, missing ones as a dash."""
    rows = [list(table.columns), ["---"] * len(table.columns)]
    rows += [["–" if pd.isna(cell) else cell for cell in row] for row in table.to_numpy().tolist()]
    return "".join(
        "| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |\n" for row in rows
    )


def write_markdown(text: str, path: Path | str) -> None:
    """Write text for people.

    Raises:
        InputError: where the file cannot be written.
    """
    try:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
