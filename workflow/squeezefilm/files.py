"""Files that are whole or not there at all, texts in UTF-8, and terminals that are in no UTF-8.

A file is written beside its place under a temporary name, brought to the disk, and renamed: who
reads its place finds the old file or the new one, and two jobs that write the same file at the
same time do not meet. What a killed job leaves is ``.NAME.RANDOM.part``.
"""

import codecs
import contextlib
import hashlib
import io
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

from squeezefilm.errors import InputError

PARTIAL_FILE_SUFFIX = ".part"
SUBSTITUTE_HANDLER_NAME = "squeezefilm.substitute"
"""The name of ``substitute`` among the error handlers of streams."""
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


@contextlib.contextmanager
def atomic_file(path: Path | str) -> Iterator[Path]:
    """A name beside the target to write to; renamed when all of it is on the disk.

    Raises InputError where the file cannot be written; what was there before stays as it was.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor, name = tempfile.mkstemp(
            dir=path.parent, prefix=f".{path.name}.", suffix=PARTIAL_FILE_SUFFIX
        )
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    part = Path(name)
    try:
        os.close(descriptor)
        yield part
        with part.open("rb") as handle:
            os.fsync(handle.fileno())
        part.chmod(0o644)
        part.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        part.unlink(missing_ok=True)


def read_text(path: Path | str, *, what: str) -> str:
    """Return the text of a file in UTF-8, without a byte order mark, its line ends as they are.

    Args:
        what: the file is, for messages: ``table``.

    Raises InputError where there is no such file or it cannot be read, and naming the line where
    it is not UTF-8.
    """
    try:
        content = Path(path).read_bytes()
        return content.decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such {what}") from None
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        hint = " (CSV UTF-8 in a spreadsheet)" if Path(path).suffix == ".csv" else ""
        raise InputError(
            f"{path}: line {line}: the {what} must be text in UTF-8; save it in this encoding{hint}"
        ) from None
    except OSError as error:
        raise InputError(f"{path}: the {what} cannot be read: {error.strerror}") from None


def write_text(text: str, path: Path | str) -> None:
    """Write a text, whole or not at all.

    Raises InputError where the file cannot be written.
    """
    with atomic_file(path) as part:
        part.write_text(text, encoding="utf-8")


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


def file_digest(path: Path) -> str:
    """The SHA-256 of a file."""
    with path.open("rb") as handle:
        return hashlib.file_digest(handle, "sha256").hexdigest()


def remove_partial_files(folder: Path) -> None:
    """Remove what killed jobs left; only right while no job writes in the folder."""
    for part in folder.rglob(f".*{PARTIAL_FILE_SUFFIX}"):
        part.unlink(missing_ok=True)
