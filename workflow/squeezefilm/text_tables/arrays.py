"""Arrays as the lines of a table: named ones of MATLAB and NumPy, a matrix over a rectangle."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.text_tables.cells import number_of_cell

ARRAY_SUFFIXES = (".mat", ".npy", ".npz")
MIN_MATRIX_COLUMNS = 8
# Largest difference of an axis' steps from their mean, over it, and the fewest that tell an axis.
MAX_AXIS_IRREGULARITY, MIN_AXIS_STEPS = 0.05, 3
MATRIX_LINE_PATTERN = re.compile(r"[#%!\s]*(width|height|value units)\s*:\s*(.*?)\s*$", re.I)
LENGTH_PATTERN = re.compile(r"(\d+(?:[.,]\d*)?(?:e[-+]?\d+)?)\s*(\S+)", re.I)
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


def matrix_as_table_lines(lines: Sequence[str]) -> tuple[list[str], list[str]]:
    """A matrix below lines that say its size, as Gwyddion writes it, as a table, and a note.

    The lines themselves, and no note, of another file.

    Raises:
        InputError: for a matrix whose first column or row is an axis.
    """
    stated = {
        match[1].lower(): match[2] for match in map(MATRIX_LINE_PATTERN.match, lines) if match
    }
    sizes = [LENGTH_PATTERN.fullmatch(stated.get(side, "")) for side in ("width", "height")]
    if None in sizes or "value units" not in stated:
        return list(lines), []
    body = [line.strip() for line in lines if re.match(r"\s*[^\s#%!]", line)]
    rows = [re.split(r"[\s;]+", line) for line in body if re.match(r"[-+.\d]|nan", line, re.I)]
    counts = {*map(len, rows)}
    is_matrix = len(rows) == len(body) and len(counts) == 1 and min(counts) >= MIN_MATRIX_COLUMNS
    if not is_matrix:
        return list(lines), []
    values = [[number_of_cell(cell.replace(",", ".")) for cell in row] for row in rows]
    _reject_axis(np.array(values))
    (width, x_unit), (height, y_unit) = (
        (float(size[1].replace(",", ".")), size[2]) for size in sizes if size
    )
    columns, sign = len(rows[0]), "," if any("," in line for line in body) else "."
    table = [f"x [{x_unit}]\ty [{y_unit}]\tamplitude [{stated['value units']}]"]
    table += [
        f"{width * (column + 0.5) / columns:.9g}\t{height * y:.9g}\t".replace(".", sign) + cell
        for y, cells in zip(1 - (np.arange(len(rows)) + 0.5) / len(rows), rows, strict=True)
        for column, cell in enumerate(cells)
    ]
    note = (
        f"a matrix of {len(rows)} × {columns} values is read at the middles of its cells, from a "
        "corner, its first row at the largest y"
    )
    return table, [note]


def _reject_axis(matrix: np.ndarray) -> None:
    """Reject a matrix whose first column or row has even steps, which the next one has not."""
    for name, first, second in (
        ("column", matrix[:, 0], matrix[:, 1]),
        ("row", matrix[0], matrix[1] if len(matrix) > 1 else matrix[0]),
    ):
        axis, beside = first[1:], second[1:]  # a corner may have anything
        if step_irregularity(axis) < MAX_AXIS_IRREGULARITY < step_irregularity(beside) / 4:
            raise InputError(
                f"the first {name} of the matrix, {axis[0]:g}, {axis[1]:g}, …, has even steps, as "
                "an axis or numbers have; delete axes, so that amplitudes are left"
            )


def step_irregularity(values: np.ndarray) -> float:
    """The largest difference of a step between values from the mean one, over this one."""
    steps = np.diff(values)
    steps = steps[np.isfinite(steps)]
    if len(steps) < MIN_AXIS_STEPS or not steps.mean():
        return math.inf
    return float(np.max(np.abs(steps / steps.mean() - 1)))


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
