"""The study that a command is asked of: the one that is named, or a checkout's own."""

from collections.abc import Sequence
from pathlib import Path

from squeezefilm.io.errors import InputError
from squeezefilm.studies.config import Config, load_sections

PAPER_CONFIG = Path(__file__).parents[3] / "config" / "paper.yaml"
"""Where the library lies in a checkout; an installed one has no study of its own."""
HELP = "the study; a checkout's paper.yaml if left out"


def study_at(path: str | None, sections: Sequence[str]) -> Config:
    """The sections of the study that a command uses; the others are not checked.

    Raises InputError where none is named and there is none, and as ``load_sections`` does.
    """
    if path is None and not PAPER_CONFIG.exists():
        raise InputError("give a study by --config CONFIG.yaml")
    return load_sections(path or PAPER_CONFIG, sections)
