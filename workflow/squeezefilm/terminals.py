"""Terminals whose encoding lacks characters: they get others that mean the same."""

import codecs
import io
from typing import TextIO

SUBSTITUTE_HANDLER_NAME = "squeezefilm.substitute"
"""The name of ``substitute_unencodable`` among the error handlers of streams."""
ASCII_SUBSTITUTES = {
    "µ": "u",
    "μ": "u",
    "±": "+/-",
    "×": "x",
    "·": "*",
    "→": "->",
    "≤": "<=",
    "≥": ">=",
}
ASCII_SUBSTITUTES |= dict.fromkeys("−–—", "-")


def substitute_unencodable(error: UnicodeError) -> tuple[str, int]:
    """Return ASCII in place of characters that a stream's encoding lacks, and their end."""
    assert isinstance(error, UnicodeEncodeError)
    characters = error.object[error.start : error.end]
    return "".join(map(_ascii_substitute, characters)), error.end


def _ascii_substitute(character: str) -> str:
    import unicodedata

    name = unicodedata.name(character, "")
    if character in ASCII_SUBSTITUTES:
        return ASCII_SUBSTITUTES[character]
    if name.startswith("GREEK"):
        return name.split()[-1].lower()
    return unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode() or "?"


codecs.register_error(SUBSTITUTE_HANDLER_NAME, substitute_unencodable)


def enable_ascii_substitutes(*streams: TextIO) -> None:
    """Let streams print substitutes for characters that their encodings lack."""
    for stream in streams:
        if isinstance(stream, io.TextIOWrapper):  # a notebook's is none
            stream.reconfigure(errors=SUBSTITUTE_HANDLER_NAME)
