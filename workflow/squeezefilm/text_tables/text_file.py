"""The lines of a table in a file of text, in whatever encoding; what to do with other files.

foreign_files.csv has the files that programs write and that are no such table: how they begin, or
what their text contains, as patterns.
"""

from __future__ import annotations

import contextlib
import csv
import io
import re
from pathlib import Path

from squeezefilm.errors import InputError
from squeezefilm.files import read_bytes, read_text
from squeezefilm.text_tables.arrays import (
    ARRAY_SUFFIXES,
    arrays_as_table_lines,
    matrix_as_table_lines,
)
from squeezefilm.text_tables.header_cells import words_of_file

FOREIGN_FILES = [
    *csv.DictReader(
        read_text(Path(__file__).with_name("foreign_files.csv"), what="list of files").splitlines()
    )
]
ASIAN_WORDS = [
    word
    for name in ("scan_words.csv", "scene_words.csv")
    for words in words_of_file(name).values()
    for word in words
    if word >= "\u3000"
]
MARKDOWN_RULE_PATTERN = re.compile(r"\s*\|?(?:\s*:?-+:?\s*\|)+(?:\s*:?-+:?)?\s*")
"""The line below the header of a table of Markdown: ``| ---: | :---: |``."""
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
    """The lines of a text in whatever encoding, those of Markdown with tabs, and a note on it.

    Raises InputError for the content of a file that is none of text, with the remedy.
    """
    _reject_foreign_file("beginning", content[:MAX_ENCODING_CHECK_CHARACTERS].decode("latin-1"))
    text, encoding = _decode_text(content)
    _reject_foreign_file("text", text[:MAX_FORMAT_CHECK_CHARACTERS])
    if text.count("\0", 0, MAX_ENCODING_CHECK_CHARACTERS) > MAX_ENCODING_CHECK_CHARACTERS / 100:
        raise InputError(f"no table of text; export one as text or CSV, with {form}")
    notes = [f"read as {encoding}"] * (encoding != "utf-8")
    text_lines = io.StringIO(text, newline=None).read().split("\n")
    return _without_markdown(text_lines), notes


def _without_markdown(lines: list[str]) -> list[str]:
    """Lines of a table of Markdown with tabs between cells; others as they are."""
    if not any(map(MARKDOWN_RULE_PATTERN.fullmatch, lines)):
        return lines
    return [
        ""
        if MARKDOWN_RULE_PATTERN.fullmatch(line)
        else "\t".join(cell.strip() for cell in line.strip(" |").split("|"))
        for line in lines
    ]


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
    for encoding, words in (("utf-8-sig", [""]), ("cp932", ASIAN_WORDS), ("gb18030", ASIAN_WORDS)):
        with contextlib.suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            if any(word in text for word in words):
                return text, encoding.removesuffix("-sig")
    encoding = "mac_roman" if MAC_ROMAN_PATTERN.search(start) else "latin-1"
    return content.decode(encoding), encoding
