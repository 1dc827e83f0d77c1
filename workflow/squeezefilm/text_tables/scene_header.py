"""The columns of scenes and measured forces as people name them, in words and with any unit.

A column's words stand in scene_words.csv. Beside them a cell may have a word of uncertainty.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from squeezefilm.text_tables.header import Column, Vocabulary
from squeezefilm.text_tables.header_cells import (
    normalised_unit,
    possible_words_and_units,
    sizes_of_normalised_units,
    words_of_file,
)

_WORDS_OF_COLUMN = words_of_file("scene_words.csv")
UNCERTAINTY_WORDS = {*_WORDS_OF_COLUMN.pop("uncertainty")}
DEVIATION_WORDS = UNCERTAINTY_WORDS | {*_WORDS_OF_COLUMN.pop("deviation")}
"""What may be called an uncertainty, standard or not."""
COLUMN_OF_WORDS = {words: name for name, several in _WORDS_OF_COLUMN.items() for words in several}
UNIT_SIZES_OF_BASE_UNIT = {
    unit.lower(): sizes_of_normalised_units(unit) for unit in ("m", "deg", "N")
}
SIZE_OF_UNIT = {
    name: size for units in UNIT_SIZES_OF_BASE_UNIT.values() for name, size in units.items()
}


def words_and_unit(cell: str) -> tuple[list[str], str]:
    """The words of a header's cell, and the unit in it, also within: ``û / µm (0-pk)``."""
    words, unit = next(possible_words_and_units(cell, SIZE_OF_UNIT))
    behind_first = map(normalised_unit, re.split(r"[\s/,()\[\]]+", cell)[:0:-1])
    return words, unit or next(
        (unit_behind for unit_behind in behind_first if unit_behind in SIZE_OF_UNIT), ""
    )


def is_peak_to_peak(words: Sequence[str]) -> bool:
    """Tell whether words name an extent, twice an amplitude."""
    text = f" {' '.join(words)} "
    return any(f" {word} " in text for word in words_of_file("scan_words.csv")["span"])


def column_and_unit(cell: str) -> tuple[str, str, float | None]:
    """The column that a header's cell names, its unit, and the size of this; None of one without.

    A cell that names none is a column by itself.
    """
    for words, unit in possible_words_and_units(cell, SIZE_OF_UNIT):
        named = [word for word in words if word not in UNCERTAINTY_WORDS]
        text = " ".join(named).removesuffix(" standard")
        columns = {
            COLUMN_OF_WORDS.get(word) for word in ([text] if text in COLUMN_OF_WORDS else named)
        }
        if len(columns) == 1 and (own := columns.pop()):
            stem, _, base = own.rpartition("_")
            name = f"{stem}_uncertainty_{base}" if named != words else own
            return name, unit, UNIT_SIZES_OF_BASE_UNIT[base].get(unit)
    return cell, "", None


class SceneVocabulary(Vocabulary):
    """The columns that a reader of scenes takes from a table, by their own names and by words."""

    units = SIZE_OF_UNIT
    places = ("x_m", "y_m", "phi_r_m")

    def __init__(self, columns: Collection[str]) -> None:
        self.taken = {*columns}

    def column(self, cell: str, column_index: int = 0) -> Column | None:
        own, unit, size = column_and_unit(cell)
        if cell in self.taken:
            own, size = cell, 1.0
        return Column(own, unit, size, column_index, cell) if own in self.taken else None

    def sized_columns(self, header: Sequence[str]) -> dict[int, Column]:
        """The columns whose units are known, by their places; none in words beside that itself."""
        return {
            column.column_index: column
            for column in self.columns(header)
            if column.size and (column.name == column.quantity or column.quantity not in header)
        }

    def size_of_unit(self, cell: str) -> float | None:
        return SIZE_OF_UNIT.get(normalised_unit(cell))

    def size_in_name(self, name: str) -> float | None:
        return 1.0 if name in self.taken else super().size_in_name(name)
