"""Reading a scanning vibrometer's file as it was exported.

A table of text has a row for each point (files/text.py finds encoding, separator and decimal sign),
and a header that names quantities and units (files/columns.py):

    x_mm, y_mm          or  r_mm  or  r_mm, phi_deg     place, from the actuator's centre
    amplitude_um        or  real_um, imaginary_um       peak amplitude, or with a sign of its own
    phase_deg           or  sign                        optional

Velocities (mm/s) are divided by the angular frequency. A row whose amplitude is empty or ``nan`` is
a point that was not measured: it is excluded from profile and noise, and a note names its line.
Universal files are read by files/universal.py.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from squeezefilm.film.vibration.files.columns import columns_of
from squeezefilm.film.vibration.files.text import read_text_table
from squeezefilm.film.vibration.files.universal import SUFFIXES, read_universal
from squeezefilm.io.errors import InputError

FEWEST_POINTS, MOST_POINTS = 8, 3_000_000
MOST_MISSING = 0.5
"""Share of a scan's points that may lack an amplitude."""
PLACES_NAMED = 6


@dataclass(frozen=True)
class Scan:
    """Measured points in metres and the complex amplitude there, each of shape (points,).

    Without angles ``y_m`` is None and ``x_m`` the distance from the centre. ``lines`` are the
    rows' places in the file and ``missing`` counts points without an amplitude. ``signed`` tells
    whether phase, sign or an amplitude below zero says on which side of a node a point is.
    ``notes`` say how the file was read; ``cell_m`` is the width of the cells over which points were
    averaged (binning.py), 0 where they were not.
    """

    path: Path
    x_m: np.ndarray
    y_m: np.ndarray | None
    amplitude_m: np.ndarray
    lines: np.ndarray
    missing: int
    signed: bool
    notes: tuple[str, ...] = ()
    cell_m: float = 0.0


def read_scan(path: Path | str, *, frequency_hz: float | None = None) -> Scan:
    """Read a vibrometer's file.

    Args:
        frequency_hz: of the vibration, for velocities and spectra; without it they are refused.

    Raises InputError naming the file and the row or column that is wrong, and what is allowed.
    """
    path = Path(path)
    scan = (_universal if path.suffix.lower() in SUFFIXES else _table)(path, frequency_hz)
    points = len(scan.x_m)
    if points > MOST_POINTS:
        raise InputError(f"{path}: {points} points; at most {MOST_POINTS} are taken")
    if points < FEWEST_POINTS:
        raise InputError(
            f"{path}: {points} measured points ({scan.missing} missing); a profile needs at least "
            f"{FEWEST_POINTS}"
        )
    if not np.any(scan.amplitude_m):
        raise InputError(f"{path}: every amplitude is zero: there is no profile")
    if scan.missing > MOST_MISSING * (points + scan.missing):
        raise InputError(
            f"{path}: {scan.missing} of {points + scan.missing} points have no amplitude; at most "
            f"{MOST_MISSING:.0%} of them may lack it"
        )
    return scan


def _excluded(places: np.ndarray, *, what: str) -> list[str]:
    """Return a note that names points without an amplitude, if there are any."""
    if not len(places):
        return []
    named = ", ".join(map(str, places[:PLACES_NAMED])) + ", …" * (len(places) > PLACES_NAMED)
    count, many = len(places), "s" * (len(places) > 1)
    return [
        f"{count} point{many} without an amplitude, excluded from profile and noise "
        f"({what}{many} {named})"
    ]


def _universal(path: Path, frequency_hz: float | None) -> Scan:
    omega = _angular_frequency(frequency_hz, path=path)
    found = read_universal(path, frequency_hz=omega / (2 * math.pi))
    amplitude = found.amplitude.astype(complex) / (omega if found.is_velocity else 1.0)
    seen = np.isfinite(amplitude)
    return Scan(
        path=path,
        x_m=found.x_m[seen],
        y_m=found.y_m[seen],
        amplitude_m=amplitude[seen],
        lines=1 + np.flatnonzero(seen),
        missing=int(np.sum(~seen)),
        signed=found.has_phase or bool(np.any(amplitude[seen].real < 0)),
        notes=(*found.notes, *_excluded(1 + np.flatnonzero(~seen), what="function")),
    )


def _table(path: Path, frequency_hz: float | None) -> Scan:
    text = read_text_table(path)
    columns, notes = columns_of(text.header, path=path, line=text.header_line)
    motion = ("amplitude", "real", "imaginary")
    rows = text.measured([each.place for each in columns if each.quantity in motion])
    table = {}
    for column in columns:
        values = text.numbers(column.place, name=column.quantity, rows=rows) * column.size
        if column.is_velocity:
            values = values / _angular_frequency(frequency_hz, path=path)
            notes.append(f"{column.name!r} divided by the angular frequency")
        table[column.quantity] = values
    lines, lacking = text.lines[rows], np.delete(text.lines, rows)
    _check_values(table, path=path, lines=lines)
    if "real" in table:
        amplitude = table["real"] + 1j * table["imaginary"]
    else:
        amplitude = table["amplitude"].astype(complex)
    if "sign" in table:
        amplitude = amplitude * table["sign"]
    if "phase" in table and "real" not in table:
        amplitude = amplitude * np.exp(1j * table["phase"])
    x_m, y_m = table.get("x"), table.get("y")
    if x_m is None:
        x_m = table["r"]
        if "phi" in table:
            x_m, y_m = x_m * np.cos(table["phi"]), x_m * np.sin(table["phi"])
    signed = {"phase", "sign", "imaginary"} & set(table) or np.any(amplitude.real < 0)
    return Scan(
        path=path,
        x_m=x_m,
        y_m=y_m,
        amplitude_m=amplitude,
        lines=lines,
        missing=len(lacking),
        signed=bool(signed),
        notes=(*text.notes, *notes, *_excluded(lacking, what="line")),
    )


def _angular_frequency(frequency_hz: float | None, *, path: Path) -> float:
    if frequency_hz is None:
        raise InputError(f"{path}: velocities and spectra need the actuator's frequency")
    return 2 * math.pi * frequency_hz


def _check_values(table: Mapping[str, np.ndarray], *, path: Path, lines: np.ndarray) -> None:
    """Refuse a radius below zero, a sign that is none, an amplitude below zero with a phase."""
    told = "amplitude" in table and ("phase" in table or "sign" in table)
    wrong = {
        "r must not be negative": "r" in table and table["r"] < 0,
        "sign must be 1 or -1": "sign" in table and np.abs(table["sign"]) != 1,
        "amplitude must not be negative where phase or sign tells its direction": (
            told and table["amplitude"] < 0
        ),
    }
    for message, rows in wrong.items():
        if np.any(rows):
            raise InputError(f"{path}: line {lines[int(np.argmax(rows))]}: {message}")
