"""Squeeze-film forces from the Reynolds equation, and empirical models of them.

    import squeezefilm as sf

    study = sf.load("config/paper.yaml")
    print(study.force(h0="5 um", hv="2.2 um"))

`load` reads a study's file, `Film.of` takes the same keys without one. Both give forces with their
errors, curves and pressure fields; a study also fits models (`Study.fit`), and `Fit.read` reads
one from its file. What is wrong with an input is told by `InputError`, what could not be computed
by `RunError`.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"
__all__ = ["Film", "Fit", "Force", "InputError", "RunError", "Scene", "Study", "load"]

# Also in __init__.pyi, which tells type checkers.
_PLACES = {
    "Film": "api.film",
    "Fit": "api.models",
    "Force": "api.forces",
    "InputError": "errors",
    "RunError": "errors",
    "Scene": "film.scene",
    "Study": "api.models",
    "load": "api.models",
}


def __getattr__(name: str) -> Any:
    """A name of the library, loaded when it is first asked for: commands need few of them."""
    if name not in _PLACES:
        raise AttributeError(f"module 'squeezefilm' has no attribute {name!r}")
    value = getattr(import_module(f"squeezefilm.{_PLACES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
