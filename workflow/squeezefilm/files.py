"""Files that are whole or not there at all, and texts in UTF-8.

A file is written beside its place under a temporary name, brought to the disk, and renamed: who
reads its place finds the old file or the new one, and two jobs that write the same file at the
same time do not meet. What a killed job leaves is ``.NAME.RANDOM.part``.
"""

import contextlib
import hashlib
import json
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from squeezefilm.errors import InputError

PARTIAL_FILE_SUFFIX = ".part"


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


def read_bytes(path: Path | str, *, what: str) -> bytes:
    """Return the bytes of a file.

    Args:
        what: the file is, for messages: ``table``.

    Raises InputError where there is no such file or it cannot be read.
    """
    try:
        return Path(path).read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such {what}") from None
    except OSError as error:
        raise InputError(f"{path}: the {what} cannot be read: {error.strerror}") from None


def read_text(path: Path | str, *, what: str) -> str:
    """Return the text of a file in UTF-8, without a byte order mark, its line ends as they are.

    Raises InputError as ``read_bytes`` does, and naming the line where it is not UTF-8.
    """
    content = read_bytes(path, what=what)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(
            f"{path}: line {line}: the {what} must be text in UTF-8; save it in this encoding"
        ) from None


def write_text(text: str, path: Path | str) -> None:
    """Write a text, whole or not at all.

    Raises InputError where the file cannot be written.
    """
    with atomic_file(path) as part:
        part.write_text(text, encoding="utf-8")


def write_json(values: dict[str, Any], path: Path | str) -> None:
    """Write a JSON file with sorted keys, whole or not at all."""
    write_text(json.dumps(values, indent=2, sort_keys=True, allow_nan=False) + "\n", path)


def read_json(path: Path | str) -> dict[str, Any]:
    """Read a JSON object.

    Raises InputError when the file is missing or not a JSON object.
    """
    text = read_text(path, what="file")
    try:
        values = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not readable as JSON: {error}") from None
    if not isinstance(values, dict):
        raise InputError(f"{path}: expected a JSON object")
    return values


def file_digest(path: Path) -> str:
    """The SHA-256 of a file."""
    with path.open("rb") as handle:
        return hashlib.file_digest(handle, "sha256").hexdigest()


def remove_partial_files(folder: Path) -> None:
    """Remove what killed jobs left; only right while no job writes in the folder."""
    for part in folder.rglob(f".*{PARTIAL_FILE_SUFFIX}"):
        part.unlink(missing_ok=True)
