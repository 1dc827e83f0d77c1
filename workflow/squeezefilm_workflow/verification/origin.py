"""The first lines of a table: the origin of its numbers."""

import os
from datetime import UTC, datetime

from squeezefilm.provenance import provenance_record
from squeezefilm.reynolds.device import choose_device


def origin_comment_lines(command: str) -> str:
    """Return the command, commit, machine and date as lines that stand above a table."""
    now = datetime.now(UTC)
    lines = {
        "command": f"squeezefilm-verification {command}",
        "commit": str(provenance_record({}, device={})["commit"])[:8],
        "machine": f"{choose_device().name}, {os.cpu_count()} cores",
        "date": f"{now.day} {now:%B %Y}",
    }
    return "".join(f"# {key}: {value}\n" for key, value in lines.items())
