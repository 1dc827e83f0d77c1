"""How far a command is, on a terminal or in a log."""

import sys
from typing import Any


def progress_bar(total: int, *, unit: str, name: str) -> Any:
    """A bar to be closed by ``with`` and moved on by its ``update(count)``; none in a log."""
    from tqdm import tqdm  # slow to import, and only needed here

    return tqdm(total=total, unit=unit, desc=name, disable=None)


def say(text: str) -> None:
    """A line about what is done next."""
    print(text, file=sys.stderr, flush=True)
