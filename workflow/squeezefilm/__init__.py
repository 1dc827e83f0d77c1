"""Squeeze-film forces from the Reynolds equation, and empirical models of them.

    >>> import squeezefilm as sf
    >>> study = sf.load("config/paper.yaml")
    >>> print(study.force(h0="5 um", hv="2.2 um"))

`load` reads a study's file, `Film.of` takes the same keys without one. Both give forces with their
errors, curves and pressure fields; a study also fits models (`Study.fit`), and `Fit.read` reads
one from its file. An invalid input raises `InputError`, a result that cannot be computed
`RunError`.
"""

import re
from importlib import import_module
from pathlib import Path
from typing import Any

__version__ = "0.2.0"

# The names of the library, in the file that tells type checkers of them.
_STUB_TEXT = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_MODULE_OF_NAME = {
    name: place for place, name in re.findall(r"from (\S+) import (\w+)", _STUB_TEXT)
}
__all__ = sorted(_MODULE_OF_NAME)


def __getattr__(name: str) -> Any:
    """A name of the library, loaded when it is first asked for: commands need few of them."""
    if name not in _MODULE_OF_NAME:
        raise AttributeError(f"module 'squeezefilm' has no attribute {name!r}")
    value = getattr(import_module(_MODULE_OF_NAME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
