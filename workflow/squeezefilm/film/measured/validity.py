"""The valid rows of a scan's table, by the columns that tell them: a status, an overrange."""

from __future__ import annotations

from collections.abc import Sequence

from squeezefilm.errors import InputError
from squeezefilm.film.measured.cells import distinct_values_text
from squeezefilm.film.measured.columns import ROW_STATUS_QUANTITIES, WORDS_OF_MEANING, ScanColumn
from squeezefilm.film.measured.scan import list_text
from squeezefilm.lazy import pd
from squeezefilm.text_tables.cells import parse_numbers
from squeezefilm.text_tables.header_cells import fold_accents

# A column of so few whole numbers may be one of codes, and of so few words a status.
MAX_STATUS_CODES = 8


def valid_rows(
    cells: pd.DataFrame, others: Sequence[ScanColumn]
) -> tuple[pd.DataFrame, list[ScanColumn], list[str]]:
    """The rows that columns of a status do not call invalid, these columns, and notes on others.

    Raises:
        InputError: for words of a status that are neither good nor bad.
    """
    read, notes = [], []
    for column in others:
        is_status = column.quantity in ROW_STATUS_QUANTITIES
        if not column.quantity:
            is_status, unused = _is_status_by_words(cells[column.column_index], column.name)
            notes += unused
        if not is_status:
            continue
        values = cells[column.column_index].map(fold_accents)
        numbers = parse_numbers(values)
        if column.quantity == "uncertain":  # -1 marks points that VIC-3D did not correlate
            if numbers.isna().any() or {*numbers[numbers < 0]} != {-1.0}:
                continue
            values = numbers.lt(0).map({True: "invalid", False: "valid"})
        codes = values.nunique() <= MAX_STATUS_CODES and bool((numbers % 1 == 0).all())
        if column.quantity != "uncertain" and numbers.notna().all() and not codes:  # a quality
            continue
        good, bad = {*WORDS_OF_MEANING["good"]}, {*WORDS_OF_MEANING["bad"]}
        if column.quantity == "valid":
            good, bad = good | {*WORDS_OF_MEANING["yes"]}, bad | {*WORDS_OF_MEANING["no"]}
        if column.quantity == "invalid":
            good, bad = good | {*WORDS_OF_MEANING["no"], ""}, bad | {*WORDS_OF_MEANING["yes"]}
        if not values.isin(good).any():
            good = good | {""}
        unclear = cells[column.column_index][~values.isin(good | bad)]
        if not unclear.empty and values.nunique() < 2:
            continue
        if not unclear.empty:
            usual = cells[column.column_index].value_counts().index[0]
            raise InputError(
                f"column {column.name!r} may tell which rows are valid, and has cells that are not "
                f"understood: {distinct_values_text(unclear)}; take valid rows by "
                f"actuator.profile.rows: "
                f"{column.name} = {usual}; or write valid or invalid, or leave it out"
            )
        read.append(column)
        wrong = values.isin(bad)
        if wrong.any():
            words = cells[column.column_index][wrong].value_counts()
            which = ", ".join(f"{word} {count}" for word, count in words.items())
            many = "s" * (len(cells[wrong]) > 1)
            notes.append(
                f"{wrong.sum()} row{many} invalid by column {column.name!r} ({which}) excluded "
                f"(line{many} {list_text(cells.index[wrong].tolist())})"
            )
        cells = cells[~wrong]
    return cells, read, notes


def _is_status_by_words(cells: pd.Series, name: str) -> tuple[bool, list[str]]:
    """Tell whether cells are words of a status, some bad, and a note where only some words are."""
    words = cells.drop_duplicates()
    if len(words) > MAX_STATUS_CODES:
        return False, []
    folded = words.map(fold_accents)
    is_bad = folded.isin({*WORDS_OF_MEANING["bad"]} - {"--"})
    are_all = bool((is_bad | folded.isin([*WORDS_OF_MEANING["good"], "--", ""])).all())
    note = (
        f"column {name!r} is not used, and has {list_text(words[is_bad].tolist())}; if these rows "
        "are invalid, call it status and write valid or invalid"
    )
    return bool(is_bad.any()) and are_all, [note] * bool(is_bad.any() and not are_all)
