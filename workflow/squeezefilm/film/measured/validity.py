"""The valid rows of a scan's table, by the columns that tell them: a status, an overrange."""

from __future__ import annotations

from collections.abc import Sequence

from squeezefilm.errors import InputError
from squeezefilm.film.measured.cells import parsed, values_in
from squeezefilm.film.measured.columns import OF_ROWS, WORDS, Column
from squeezefilm.film.measured.scan import listed
from squeezefilm.headers import folded
from squeezefilm.lazy import pd

# A column of so few whole numbers may be one of codes.
MOST_CODES = 8


def valid_rows(
    cells: pd.DataFrame, others: Sequence[Column]
) -> tuple[pd.DataFrame, list[Column], list[str]]:
    """The rows that columns of a status do not call invalid, these columns, and notes on others.

    Raises:
        InputError: for words of a status that are neither good nor bad.
    """
    read, notes = [], []
    for column in others:
        if column.quantity not in OF_ROWS:
            continue
        values = cells[column.place].map(folded)
        numbers = parsed(values)
        codes = values.nunique() <= MOST_CODES and bool((numbers % 1 == 0).all())
        if numbers.notna().all() and not codes:  # a measured quality
            continue
        good, bad = {*WORDS["good"]}, {*WORDS["bad"]}
        if column.quantity == "valid":
            good, bad = good | {*WORDS["yes"]}, bad | {*WORDS["no"]}
        if column.quantity == "invalid":
            good, bad = good | {*WORDS["no"], ""}, bad | {*WORDS["yes"]}
        if not values.isin(good).any():
            good = good | {""}
        unclear = cells[column.place][~values.isin(good | bad)]
        if not unclear.empty and values.nunique() < 2:
            continue
        if not unclear.empty:
            usual = cells[column.place].value_counts().index[0]
            raise InputError(
                f"column {column.name!r} may tell which rows are valid, and has cells that are not "
                f"understood: {values_in(unclear)}; take valid rows by actuator.profile.rows: "
                f"{column.name} = {usual}; or write valid or invalid, or leave it out"
            )
        read.append(column)
        wrong = values.isin(bad)
        if wrong.any():
            words = cells[column.place][wrong].value_counts()
            which = ", ".join(f"{word} {count}" for word, count in words.items())
            many = "s" * (len(cells[wrong]) > 1)
            notes.append(
                f"{wrong.sum()} row{many} invalid by column {column.name!r} ({which}) excluded "
                f"(line{many} {listed(cells.index[wrong].tolist())})"
            )
        cells = cells[~wrong]
    return cells, read, notes
