"""The study that a command is asked of: the one that is named, or a checkout's own."""

from pathlib import Path

from squeezefilm.config.loading import Config, load_film
from squeezefilm.errors import InputError

PAPER_CONFIG = Path(__file__).parents[3] / "config" / "paper.yaml"
"""Where the library lies in a checkout; an installed one has no study of its own."""
HELP = "the study; a checkout's paper.yaml if left out"


def film_at(path: str | None) -> Config:
    """The sections of the study that a film and its solver need; the others are not checked.

    Raises InputError where none is named and there is none, and as ``load_film`` does.
    """
    if path is None and not PAPER_CONFIG.exists():
        raise InputError("give a study by --config CONFIG.yaml")
    return load_film(path or PAPER_CONFIG)
