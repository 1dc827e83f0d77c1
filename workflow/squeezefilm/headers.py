"""Cells of a table's header as people and programs write them: words, and the unit beside them.

``x_mm``, ``X [mm]``, ``X/mm``, ``x position mm``, ``Phase in Grad``, ``w (um) @ freq=43270``. This
is the only place that takes them apart: what words mean is up to each kind of table.
"""

import re
import unicodedata
from collections.abc import Collection, Iterator

UNIT_NAMES = {
    name: unit
    for unit, names in {
        "deg": "degree degrees grad degre degres grados gradi",
        "rad": "radian radians",
        "m": "meter meters metre metres",
        "mm": "millimeter millimeters millimetre millimetres",
        "um": "micron microns micrometer micrometers micrometre micrometres",
    }.items()
    for name in names.split()
}
"""Other names of units, without accents."""
BREAK, BETWEEN_WORDS = re.compile(r"[\s_/,\[(]+"), re.compile(r"[\s_\-.:()\[\]/]+")


def folded(text: str) -> str:
    """A text in small letters without accents, quotes and blanks around it."""
    letters = unicodedata.normalize("NFKD", text.strip("\"' \t").casefold())
    return "".join(each for each in letters if not unicodedata.combining(each))


def unit_in(text: str) -> str:
    """A unit with its brackets taken off, in one spelling: ``(Degrees)`` is ``deg``."""
    unit = re.sub(r"/s(?:ec)?\^?2$", "/s²", folded(text).strip(" []()"))
    unit = re.sub(r"/sec$", "/s", unit)
    return UNIT_NAMES.get(unit, unit)


def words_and_unit(cell: str, units: Collection[str]) -> Iterator[tuple[list[str], str]]:
    """The ways to read a header's cell, the likeliest first: its words, and its unit or ``""``.

    First come known units, then none, then the last word as a unit that is not known.
    """
    name = folded(cell.partition("@")[0]).rstrip(" _")
    ends = [(name[: at.start()], unit_in(name[at.end() :])) for at in BREAK.finditer(name)]
    # Decibels are known, to be named in a message: the file does not tell what 0 dB is.
    known = [end for end in ends if end[1] in units or "db" in end[1]]
    for words, unit in (*known, (name, ""), *ends[-1:]):
        yield [word for word in BETWEEN_WORDS.split(words) if word], unit
