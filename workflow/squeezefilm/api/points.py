"""Points as a table; apart, since one point needs no pandas, which takes long to load."""

from __future__ import annotations

from contextlib import AbstractContextManager

import pandas as pd

MAX_COLUMN_CHARACTERS = 80


class Points(pd.DataFrame):
    """A table with a row for each point, as pandas has it, which shows what it holds.

    All columns, and 2.2e-06 for what pandas shows as 0.000002 where no other format is set.
    """

    @property
    def _constructor(self) -> type[Points]:
        return Points

    def __repr__(self) -> str:
        with _untruncated_display():
            return str(super().__repr__())

    def _repr_html_(self) -> str | None:
        with _untruncated_display():
            html: str | None = super()._repr_html_()  # type: ignore[misc]
            return html


def _untruncated_display() -> AbstractContextManager[None]:
    number = pd.get_option("display.float_format") or "{:.6g}".format
    whole = ("display.width", MAX_COLUMN_CHARACTERS, "display.max_columns", None)
    return pd.option_context(*whole, "display.float_format", number)
