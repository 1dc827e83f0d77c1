"""The lines of a table in a file of text, in whatever encoding; what to do with other files.

foreign_files.csv has the files that programs write and that are no such table: how they begin, or
what their text contains, as patterns.
"""

from __future__ import annotations

import contextlib
import csv
import html
import io
import json
import re
from pathlib import Path
from typing import Any

from squeezefilm.errors import InputError
from squeezefilm.files import read_bytes, read_text
from squeezefilm.text_tables.arrays import (
    ARRAY_SUFFIXES,
    arrays_as_table_lines,
    matrix_as_table_lines,
)
from squeezefilm.text_tables.header_cells import fold_accents, words_of_file

FOREIGN_FILES = [
    *csv.DictReader(
        read_text(Path(__file__).with_name("foreign_files.csv"), what="list of files").splitlines()
    )
]
WORDS_OF_OTHER_ALPHABETS = [
    word
    for name in ("scan_words.csv", "scene_words.csv")
    for words in words_of_file(name).values()
    for word in words
    if len(word) > 1 and max(word) > "\u00ff"
]
"""Words that an encoding of one byte a letter has only if it is that of the file."""
ENCODINGS = ("cp932", "gb18030", "cp949", "cp1251", "cp1250")
BARRED_ROW_PATTERN = re.compile(r"\d[\s$]*[|│&][\s$]*[-+.\d]")
NUMBER_ROW_PATTERN = re.compile(r"[\s|│$]*[-+.]?\d")
OUTER_BAR_PATTERN = re.compile(r"^[|│]|[|│]$")
"""One bar at each end of a row: beside a second one is an empty cell."""
RULE_BETWEEN_ROWS_PATTERN = re.compile(r"[\s|:+=_\-─━│├┤┼┌┐└┘┬┴╞╡╪]*|\s*\\[a-z]+\b[^&]*")
"""``| ---: | :---: |`` in Markdown, ``+----+`` of a database, ``\\hline`` in LaTeX."""
LATEX_SIGNS = {"$": "", "\\mu": "µ", "^\\circ": "°", "{": "", "}": ""}
MARKUP_PATTERN = re.compile(r"\s*(?:<|\{|\[\s*[\[{\"])")
HTML_CELL_PATTERN = re.compile(r"<t[dh][^>]*>(.*?)</t[dh]>", re.DOTALL | re.IGNORECASE)
MAC_ROMAN_PATTERN = re.compile(rb"\W\xa1\W|[a-z][\x8a\x8e\x8f\x9a\x9f]")
"""A degree sign, or accents within words, that are signs in Latin-1 and Windows' alphabet."""
MAX_ENCODING_CHECK_CHARACTERS, MAX_FORMAT_CHECK_CHARACTERS = 1000, 20_000


def read_table_lines(path: Path, *, what: str, form: str) -> tuple[list[str], list[str]]:
    """A file's lines, and a note on its encoding.

    Args:
        what, form: what the table is and what it needs, for messages.

    Raises InputError for a file that cannot be read or is none of text, with the remedy.
    """
    if path.suffix.lower() in ARRAY_SUFFIXES:
        return arrays_as_table_lines(path), ["its variables are read as columns"]
    text_lines, notes = lines_of_text(read_bytes(path, what=what), form=form)
    lines, matrix = matrix_as_table_lines(text_lines)
    return lines, notes + matrix


def lines_of_text(content: bytes, *, form: str) -> tuple[list[str], list[str]]:
    """The lines of a text in whatever encoding, those with bars with tabs, and a note on it.

    Raises InputError for the content of a file that is none of text, with the remedy.
    """
    _reject_foreign_file("beginning", content[:MAX_ENCODING_CHECK_CHARACTERS].decode("latin-1"))
    text, encoding = _decode_text(content)
    _reject_foreign_file("text", text[:MAX_FORMAT_CHECK_CHARACTERS])
    if text.count("\0", 0, MAX_ENCODING_CHECK_CHARACTERS) > MAX_ENCODING_CHECK_CHARACTERS / 100:
        raise InputError(f"no table of text; export one as text or CSV, with {form}")
    if MARKUP_PATTERN.match(text):
        text = _rows_of_markup(text.strip())
    notes = [f"read as {encoding}"] * (encoding != "utf-8")
    text_lines = io.StringIO(text, newline=None).read().split("\n")
    have_bars = any(sign in text for sign in "|│&")
    return _without_bars(text_lines) if have_bars else text_lines, notes


def _rows_of_markup(text: str) -> str:
    """The rows of a table in HTML, or of lists or records in brackets (JSON, Mathematica), by line.

    Raises InputError for another text.
    """
    rows: list[Any] = [
        [html.unescape(re.sub("<[^>]*>", "", cell)) for cell in HTML_CELL_PATTERN.findall(row)]
        for row in re.split("<tr", text, flags=re.IGNORECASE)[1:]
    ]
    try:
        records = re.sub(r"\}\s*\{", "},{", text)
        rows = rows or json.loads(records if records[:1] == "[" else f"[{records}]")
    except ValueError:
        lists = re.findall(r"[\[{]([^\[\]{}]*)[\]}]", text)
        rows = [*csv.reader((" ".join(row.split()) for row in lists), skipinitialspace=True)]
    if all(isinstance(row, dict) and row.keys() == rows[0].keys() for row in rows):
        rows = [[*rows[0]], *([row[key] for key in rows[0]] for row in rows)]
    are_lists = len(rows) > 1 and all(isinstance(row, list) for row in rows)
    if not are_lists or len({*map(len, rows)}) > 1 or len(rows[0]) < 2:
        raise InputError("no table of text; write the points as CSV")
    return "\n".join("\t".join(str(cell).strip() for cell in row) for row in rows)


def _without_bars(lines: list[str]) -> list[str]:
    """Lines of a table with bars (Markdown, databases) or & (LaTeX) between cells, with tabs there.

    Lines of words without bars among and below its rows are empty then; others stay as they are.
    """
    barred = sum(bool(BARRED_ROW_PATTERN.search(line)) for line in lines)
    if 2 * barred <= sum(bool(NUMBER_ROW_PATTERN.match(line)) for line in lines):
        return lines
    first = next(at for at, line in enumerate(lines) if re.search("[|│&]", line))
    for at, line in enumerate(lines):
        row = OUTER_BAR_PATTERN.sub("", re.sub(r"\\\\.*", "", line).strip())
        cells = re.split("[|│&]", row)
        is_beside = at > first and len(cells) == 1 and not NUMBER_ROW_PATTERN.match(line)
        if RULE_BETWEEN_ROWS_PATTERN.fullmatch(line) or is_beside:
            cells = []
        lines[at] = "\t".join(map(str.strip, cells))
        for sign, text in LATEX_SIGNS.items():
            lines[at] = lines[at].replace(sign, text)
    return lines


def _reject_foreign_file(part: str, text: str) -> None:
    find = {"beginning": re.match, "text": re.search}[part]
    for foreign in FOREIGN_FILES:
        if foreign["part"] == part and find(foreign["pattern"], text):
            raise InputError(foreign["remedy"])


def _decode_text(content: bytes) -> tuple[str, str]:
    """A text and its encoding: by the byte order mark, by zeros between letters, or as it fits."""
    start, half = content[:1000], min(len(content), 1000) / 4
    little = start.startswith(b"\xff\xfe") or start[1::2].count(0) > half
    if little or start.startswith(b"\xfe\xff") or start[::2].count(0) > half:
        encoding = "utf-16-le" if little else "utf-16-be"
        return content.decode(encoding, errors="replace").removeprefix("\ufeff"), encoding
    for encoding in ("utf-8-sig", *ENCODINGS):
        with contextlib.suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            folded = fold_accents(text[:MAX_FORMAT_CHECK_CHARACTERS])
            if encoding == "utf-8-sig" or any(word in folded for word in WORDS_OF_OTHER_ALPHABETS):
                return text, encoding.removesuffix("-sig")
    encoding = "mac_roman" if MAC_ROMAN_PATTERN.search(start) else "latin-1"
    return content.decode(encoding), encoding
