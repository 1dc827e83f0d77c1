"""Cells of a table's header as people and programs write them: words, and the unit beside them.

``x_mm``, ``X [mm]``, ``X/mm``, ``x position mm``, ``Phase in Grad``, ``w (um) @ freq=43270``. This
is the only place that takes them apart: what words mean is up to each kind of table.
"""

import csv
import re
import unicodedata
from collections.abc import Collection, Iterator
from pathlib import Path

from squeezefilm.files import read_text
from squeezefilm.units import unit_sizes

UNIT_OF_NAME = {
    name: unit
    for unit, names in {
        "deg": "degree degrees grad degre degres grados gradi graus graden grader град 度 도 °",
        "rad": "radian radians 弧度",
        "g": "gs",
        "m": "meter meters metre metres 米 м",
        "mm": "millimeter millimeters millimetre millimetres 毫米 мм",
        "in": "inch inches",
        "mil": "mils thou",
        "uin": "\u03bcin microinch microinches",
        "in/s": "ips",
        "um": "\u03bcm micron microns micrometer micrometers micrometre micrometres 微米 мкм",
        "nm": "nanometer nanometers nanometre nanometres 纳米 нм",
        "hz": "赫兹 гц",
        "khz": "千赫 кгц",
    }.items()
    for name in unicodedata.normalize("NFKD", names).split()
}
"""Other names of units, without accents."""
PER_SECOND_PATTERN = re.compile(r"[/_](?:s(?:ec)?|秒|с)\^?([12]?)$|\W*s(?:ec)?\^?[-\u2212]([12])$")
"""The end of m/s, mm_s, m/sec^2, m s-1."""
ORIGIN_MICRO_ESCAPE = r"\g(m)"
UNIT_START_PATTERN = re.compile(r"[\s_/,.\[(]+")
WORD_SEPARATOR_PATTERN = re.compile(r"[\s,_\-.:()\[\]/]+")


def fold_accents(text: str) -> str:
    """A text in small letters without accents, quotes and blanks around it."""
    letters = unicodedata.normalize("NFKD", text.strip("\"' \t").casefold())
    return "".join(each for each in letters if not unicodedata.combining(each))


def sizes_of_normalised_units(unit: str) -> dict[str, float]:
    """The units that measure what a unit does, as ``normalised_unit`` has them, and their sizes."""
    inches = {"in": 0.0254, "mil": 25.4e-6, "uin": 25.4e-9} if unit == "m" else {}
    return {fold_accents(name): size for name, size in unit_sizes(unit).items()} | inches


def normalised_unit(text: str) -> str:
    """A unit with its brackets taken off, in one spelling: ``(Degrees)`` is ``deg``."""
    unit = fold_accents(text).replace(ORIGIN_MICRO_ESCAPE, "u").strip(" []")
    if not re.match(r"\([^()]*\)\S", unit):
        unit = unit.strip(" []()")
    unit = re.sub("[_ ](?:per|pro|par|por)[_ ]", "/", unit)
    unit = PER_SECOND_PATTERN.sub(lambda end: "/s²" if "2" in end.groups() else "/s", unit)
    length, per, time = unit.partition("/")
    return UNIT_OF_NAME.get(unit, UNIT_OF_NAME.get(length, length) + per + time)


def possible_words_and_units(cell: str, units: Collection[str]) -> Iterator[tuple[list[str], str]]:
    """The ways to read a header's cell, the likeliest first: its words, and its unit or ``""``.

    First come known units, then none, then what is in brackets, or the last word, as a unit that is
    not known.
    """
    name = fold_accents(cell.partition("@")[0]).rstrip(" _.")
    ends = [
        (name[: at.start()], normalised_unit(name[at.end() :]))
        for at in UNIT_START_PATTERN.finditer(name)
    ]
    # Decibels are known, to be named in a message: the file does not tell what 0 dB is.
    known = [end for end in ends if end[1] in units or end[1].startswith("db")]
    bracket = [
        (name[: at.start()], normalised_unit(name[at.end() :]))
        for at in re.finditer(r"\s*(?:\[(?=[^\[\]]*\]$)|[\[(](?=[^\[(]*[\])]$))", name)
    ]
    for words, unit in (*known, (name, ""), *bracket, *ends[-1:]):
        yield [word for word in WORD_SEPARATOR_PATTERN.split(words) if word], unit


def words_of_file(name: str) -> dict[str, list[str]]:
    """The words of each meaning in a list of words, without accents."""
    text = read_text(Path(__file__).with_name(name), what="list of words")
    rows = csv.reader(text.splitlines()[1:])
    return {meaning: fold_accents(words).split(";") for meaning, words in rows}
