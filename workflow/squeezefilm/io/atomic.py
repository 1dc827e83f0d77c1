"""Files that are whole or not there at all.

A file is written beside its place under a name of its own, brought to the disk, and renamed: who
reads its place finds the old file or the new one, and two jobs that write the same file at the
same time do not meet. What a killed job leaves is ``.NAME.RANDOM.part``.
"""

import contextlib
import hashlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from squeezefilm.io.errors import InputError

PART = ".part"


@contextlib.contextmanager
def whole_file(path: Path | str) -> Iterator[Path]:
    """A name beside the target to write to; renamed when all of it is on the disk.

    Raises InputError where the file cannot be written; what was there before stays as it was.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=PART)
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


def write_text(text: str, path: Path | str) -> None:
    """Write a text, whole or not at all.

    Raises InputError where the file cannot be written.
    """
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")


def digest(path: Path) -> str:
    """The SHA-256 of a file."""
    with path.open("rb") as handle:
        return hashlib.file_digest(handle, "sha256").hexdigest()


def remove_parts(folder: Path) -> None:
    """Remove what killed jobs left; only right while no job writes in the folder."""
    for part in folder.rglob(f".*{PART}"):
        part.unlink(missing_ok=True)
