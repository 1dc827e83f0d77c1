"""Reading a scanning vibrometer's table.

A scan is a CSV file with one row per point. Its header names quantity and unit:

    x_mm, y_mm          or  r_mm  or  r_mm, phi_deg     place, from the actuator's centre
    amplitude_um                                        peak amplitude, or with a sign of its own
    phase_deg           or  sign                        optional

Units: m, mm, um (or µm) and nm; deg and rad. A row whose amplitude is empty or ``nan`` is a point
that could not be measured and is left out.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from squeezefilm.io.cells import finite_number, read_cells
from squeezefilm.io.errors import InputError
from squeezefilm.io.typed_units import sizes

LENGTHS_M = sizes("m")
ANGLES_RAD = {name: math.radians(degrees) for name, degrees in sizes("deg").items()}
UNITS: Mapping[str, Mapping[str, float]] = {
    "x": LENGTHS_M,
    "y": LENGTHS_M,
    "r": LENGTHS_M,
    "phi": ANGLES_RAD,
    "amplitude": LENGTHS_M,
    "phase": ANGLES_RAD,
    "sign": {"": 1.0},
}
PLACES = ({"x", "y"}, {"r", "phi"}, {"r"})
COLUMN = re.compile(r"(?P<quantity>[a-z]+?)(?:_(?P<unit>[^_]+))?")
FORM = "columns such as x_mm, y_mm, amplitude_um, phase_deg or r_mm, amplitude_um"

FEWEST_POINTS, MOST_POINTS = 8, 20_000
LARGEST = 1e9


@dataclass(frozen=True)
class Scan:
    """Measured points in metres and the complex amplitude there, each of shape (points,).

    Without angles ``y_m`` is None and ``x_m`` the distance from the centre. ``lines`` are the
    rows' places in the file and ``missing`` counts points without an amplitude. ``signed`` tells
    whether phase, sign or an amplitude below zero says on which side of a node a point is.
    """

    path: Path
    x_m: np.ndarray
    y_m: np.ndarray | None
    amplitude_m: np.ndarray
    lines: np.ndarray
    missing: int
    signed: bool


def read_scan(path: Path | str) -> Scan:
    """Read a vibrometer's table.

    Raises InputError naming the file and the row or column that is wrong, and what is allowed.
    """
    path = Path(path)
    header, rows = read_cells(path, what="scan", needs=FORM, comments=True)
    scale = _columns(header, path=path)
    values: list[list[float]] = []
    lines: list[int] = []
    missing = 0
    for line, cells in rows:
        row = dict(zip(scale, cells, strict=True))
        if row["amplitude"].lower() in ("", "nan", "na"):
            missing += 1
            continue
        numbers = {
            name: finite_number(row[name], path=path, line=line, name=name, largest=LARGEST)
            for name in scale
        }
        values.append([number * scale[name] for name, number in numbers.items()])
        lines.append(line)
    if len(values) > MOST_POINTS:
        raise InputError(f"{path}: {len(values)} points; at most {MOST_POINTS} are taken")
    if len(values) < FEWEST_POINTS:
        raise InputError(
            f"{path}: {len(values)} measured points ({missing} missing); a profile needs at least "
            f"{FEWEST_POINTS}"
        )
    table = dict(zip(scale, np.array(values).T, strict=True))
    _check_values(table, path=path, lines=lines)
    amplitude = table["amplitude"].astype(complex)
    if "sign" in table:
        amplitude *= table["sign"]
    if "phase" in table:
        amplitude *= np.exp(1j * table["phase"])
    x_m, y_m = table.get("x"), table.get("y")
    if x_m is None:
        x_m = table["r"]
        if "phi" in table:
            x_m, y_m = x_m * np.cos(table["phi"]), x_m * np.sin(table["phi"])
    return Scan(
        path=path,
        x_m=x_m,
        y_m=y_m,
        amplitude_m=amplitude,
        lines=np.array(lines),
        missing=missing,
        signed=bool({"phase", "sign"} & set(table) or np.any(table["amplitude"] < 0)),
    )


def _columns(header: list[str], *, path: Path) -> dict[str, float]:
    """The quantities in the order of the columns, each with the size of its unit in SI."""
    scale: dict[str, float] = {}
    for name in header:
        match = COLUMN.fullmatch(name)
        quantity, unit = (match["quantity"], match["unit"] or "") if match else ("", "")
        if quantity not in UNITS:
            raise InputError(f"{path}: line 1: unknown column {name!r}; a scan has {FORM}")
        if unit not in UNITS[quantity]:
            units = ", ".join(f"{quantity}_{unit}" for unit in UNITS[quantity] if unit)
            raise InputError(
                f"{path}: line 1: column {name!r} needs a unit, one of {units or quantity}"
            )
        if quantity in scale:
            raise InputError(f"{path}: line 1: the column {quantity!r} stands twice")
        scale[quantity] = UNITS[quantity][unit]
    place = set(scale) & {"x", "y", "r", "phi"}
    if place not in PLACES:
        raise InputError(
            f"{path}: line 1: the place of a point is x and y, or r, or r and phi; "
            f"the columns are {', '.join(header)}"
        )
    if "amplitude" not in scale:
        raise InputError(f"{path}: line 1: column 'amplitude_um' is missing; a scan has {FORM}")
    if {"sign", "phase"} <= set(scale):
        raise InputError(f"{path}: line 1: give sign or phase, not both")
    return scale


def _check_values(table: Mapping[str, np.ndarray], *, path: Path, lines: list[int]) -> None:
    """Refuse a radius below zero, a sign that is none, an amplitude below zero with a phase."""
    wrong = {
        "r must not be negative": "r" in table and table["r"] < 0,
        "sign must be 1 or -1": "sign" in table and np.abs(table["sign"]) != 1,
        "amplitude must not be negative where phase or sign tells its direction": (
            ("phase" in table or "sign" in table) and table["amplitude"] < 0
        ),
    }
    for message, rows in wrong.items():
        if np.any(rows):
            raise InputError(f"{path}: line {lines[int(np.argmax(rows))]}: {message}")
    if not np.any(table["amplitude"]):
        raise InputError(f"{path}: every amplitude is zero: there is no profile")
