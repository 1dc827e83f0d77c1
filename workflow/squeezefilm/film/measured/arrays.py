"""Named arrays of MATLAB and NumPy as the lines of a table: a name is a column's, with its unit."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from squeezefilm.errors import InputError

ARRAY_SUFFIXES = (".mat", ".npy", ".npz")
ARRAYS_FORMAT_TEXT = (
    "variables of equal size named as columns are, such as x_mm, y_mm, amplitude_um"
)


def arrays_as_table_lines(path: Path) -> list[str]:
    """The lines of a table: the names of the arrays of most values, and these.

    Raises:
        InputError: for a file that cannot be read, or whose arrays have no names.
    """
    arrays = {
        name: np.ravel(values)
        for name, values in _arrays_by_name(path).items()
        if not name.startswith("__") and np.asarray(values).dtype.kind in "fciu"
    }
    most = max((len(values) for values in arrays.values()), default=0)
    columns = {name: values for name, values in arrays.items() if len(values) == most}
    if len(columns) < 2:
        raise InputError(f"a scan in such a file is {ARRAYS_FORMAT_TEXT}")
    texts = ([str(value).strip("()") for value in values] for values in columns.values())
    return ["\t".join(columns), *map("\t".join, zip(*texts, strict=True))]


def _arrays_by_name(path: Path) -> Mapping[str, Any]:
    """The arrays of a file by their names."""
    try:
        if path.suffix.lower() == ".mat":
            from scipy.io import loadmat

            return loadmat(path)
        arrays = np.load(path)
        if not isinstance(arrays, np.ndarray):
            return dict(arrays)
        return {name: arrays[name] for name in arrays.dtype.names or ()}
    except NotImplementedError:
        raise InputError("MATLAB 7.3 wrote this file; save it again with '-v7'") from None
    except Exception as error:  # whatever a damaged file makes of it
        raise InputError(f"the arrays cannot be read: {error}") from None
