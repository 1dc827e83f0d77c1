"""Tables handed to a command as NAME=PATH, so that no command guesses which file is which."""

import io
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from squeezefilm.io.atomic import read_text
from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import as_in


def parse_sources(words: Sequence[str], *, names: Sequence[str], user: str) -> dict[str, Path]:
    """The path of every name that ``user`` (a figure, a table, …) needs.

    Raises InputError for a word without ``=``, a name that is unknown, given twice or missing.
    """
    needed = " ".join(f"{name}=PATH" for name in names) or "no table"
    sources: dict[str, Path] = {}
    for word in words:
        name, equals, path = word.partition("=")
        if not (equals and path):
            raise InputError(f"{user}: {word!r} is not NAME=PATH; give {needed}")
        if name not in names:
            raise InputError(f"{user}: there is no input {name!r}; give {needed}")
        if name in sources:
            raise InputError(f"{user}: {name!r} is given twice")
        sources[name] = Path(path)
    missing = [name for name in names if name not in sources]
    if missing:
        raise InputError(f"{user}: {', '.join(missing)} is missing; give {needed}")
    return sources


def read_columns(path: Path | str, *, columns: Sequence[str]) -> pd.DataFrame:
    """Read a table that one of our commands wrote and that has at least these columns.

    Positions, named in polar form, may be in Cartesian form.
    Raises InputError naming the file and the column that is missing, or a file without rows.
    """
    text = read_text(path, what="table")
    try:
        data = pd.read_csv(io.StringIO(text))
    except (pd.errors.EmptyDataError, pd.errors.ParserError) as error:
        raise InputError(f"{path}: the table cannot be read: {error}") from None
    columns = as_in(columns, data.columns)
    for name in columns:
        if name not in data.columns:
            raise InputError(
                f"{path}: column {name!r} is missing; it must have {', '.join(columns)}"
            )
    if data.empty:
        raise InputError(f"{path}: the table has a header and no rows")
    return data
