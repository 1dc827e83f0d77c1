"""A scanning vibrometer's file as it was exported, read as points and complex amplitudes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from squeezefilm.errors import InputError, naming, refuse
from squeezefilm.film.measured.scan import FEWEST_POINTS, Scan
from squeezefilm.film.measured.table import read_table
from squeezefilm.film.measured.universal import read_universal

UNIVERSAL = (".uff", ".unv", ".uf", ".bunv")


def read_scan(path: Path | str, *, frequency_hz: float | None = None, rows: str = "") -> Scan:
    """Read a vibrometer's file.

    Args:
        path: a table of text, or a universal file by its ending.
        frequency_hz: of the vibration, for velocities and spectra; without it they are invalid.
        rows: ``COLUMN = VALUE`` of the rows that are taken from a table with several measurements,
            with semicolons between several conditions.

    Raises:
        InputError: naming the file and the row or column that is wrong, and what is allowed.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: there is no such scan")
    with naming(path):
        universal = path.suffix.lower() in UNIVERSAL
        if universal and rows:
            raise InputError("actuator.profile.rows is of tables; a universal file has no columns")
        scan = (
            read_universal(path, frequency_hz)
            if universal
            else read_table(path, frequency_hz, rows)
        )
    points = len(scan.x_m)
    refuse(
        path,
        {
            f"{points} measured points ({scan.missing} missing); a profile needs at least "
            f"{FEWEST_POINTS}": points < FEWEST_POINTS,
            "every amplitude is zero: there is no profile": not np.any(scan.amplitude_m),
        },
    )
    return scan
