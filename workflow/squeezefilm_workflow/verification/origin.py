"""The first lines of a table: the origin of its numbers."""

import os
from datetime import UTC, datetime
from pathlib import Path

import pandas as pd

from squeezefilm.files import write_text
from squeezefilm.provenance import provenance_record
from squeezefilm.reynolds.device import choose_device


def write_with_origin(table: pd.DataFrame, path: Path | str, *, command: str, about: str) -> None:
    """Write a table below lines with the command, commit, machine, date and what it is about."""
    now = datetime.now(UTC)
    lines = {
        "command": f"squeezefilm-verification {command}",
        "commit": str(provenance_record({}, device={})["commit"])[:8],
        "machine": f"{choose_device().name}, {os.cpu_count()} cores",
        "date": f"{now.day} {now:%B %Y}",
        "about": about,
    }
    head = "".join(f"# {key}: {value}\n" for key, value in lines.items())
    write_text(head + table.to_csv(index=False), path)
