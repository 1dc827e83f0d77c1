"""A scanning vibrometer's file as it was exported, read as points and complex amplitudes."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from squeezefilm.errors import InputError, prefix_errors, raise_first_problem
from squeezefilm.film.measured.scan import (
    MIN_SCAN_POINTS,
    NO_REMEDIES,
    SAME_POSITION_DISTANCE_M,
    PointRemedies,
    Scan,
)
from squeezefilm.film.measured.table import read_table
from squeezefilm.film.measured.universal import read_universal_file

UNIVERSAL_FILE_SUFFIXES = (".uff", ".unv", ".uf", ".bunv")


def read_scan(
    path: Path | str,
    *,
    frequency_hz: float,
    rows: str = "",
    origin_m: tuple[float, float] = (0.0, 0.0),
    remedies: PointRemedies = NO_REMEDIES,
) -> Scan:
    """Read a vibrometer's file.

    Args:
        path: a table of text or of named arrays, or a universal file by its ending.
        frequency_hz: of the vibration, for velocities and spectra.
        rows: ``COLUMN = VALUE`` of the rows that are taken from a table with several measurements,
            with semicolons between several conditions; ``mode = NUMBER`` of a universal file.
        origin_m: where the surface's centre is in the file's coordinates.
        remedies: what else the points need, to be told in the first message.

    Raises:
        InputError: naming the file and the row or column that is wrong, and what is allowed.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{os.path.normpath(path)}: there is no such scan")
    with prefix_errors(path):
        if path.suffix.lower() in UNIVERSAL_FILE_SUFFIXES:
            scan = read_universal_file(path, frequency_hz, rows)
        else:
            scan = read_table(path, frequency_hz, rows, remedies)
    x_m, y_m = scan.x_m - origin_m[0], scan.y_m - origin_m[1]
    on_axis = any(np.all(np.abs(each) < SAME_POSITION_DISTANCE_M) for each in (x_m, y_m))
    is_radial = scan.is_radial or on_axis
    scan = replace(scan, x_m=x_m, y_m=y_m, origin_m=origin_m, is_radial=is_radial)
    points = len(scan.x_m)
    raise_first_problem(
        path,
        {
            f"{points} measured points ({scan.missing_count} missing); a profile needs at least "
            f"{MIN_SCAN_POINTS}; of fewer, fit a curve and say actuator.profile: {{kind: formula, "
            "expression: …}": points < MIN_SCAN_POINTS,
            "every amplitude is zero: there is no profile": not np.any(scan.amplitude_m),
        },
    )
    return scan
