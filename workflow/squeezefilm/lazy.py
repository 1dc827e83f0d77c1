"""pandas and PyOpenCL, imported when they are first used: they take longer than reading a study."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd
    import pyopencl as cl
else:

    class _Lazy:
        def __init__(self, package: str) -> None:
            self._package = package

        def __getattr__(self, name: str) -> Any:
            value = getattr(import_module(self._package), name)
            setattr(self, name, value)
            return value

    pd, cl = _Lazy("pandas"), _Lazy("pyopencl")

__all__ = ["cl", "pd"]
