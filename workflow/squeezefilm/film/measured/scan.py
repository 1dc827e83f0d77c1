"""A scan: measured points and the complex amplitude at each, however they were exported."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

# In metres or radians. Writers of universal files, pyuff too, put 1.8e308 for infinity.
MAX_FINITE_VALUE = 1e9
MIN_SCAN_POINTS, MAX_LISTED_ITEMS = 8, 6
# Places closer than this are one.
SAME_POSITION_DISTANCE_M = 1e-6
# From the frequency, in distances between lines; of a file with one line as a share of it.
MAX_OFFSET_IN_LINE_SPACINGS, MAX_FREQUENCY_OFFSET_FRACTION = 0.6, 0.01
# Of a model's mode, which need not be where the actuator's is.
MAX_MODE_DISTANCE_FRACTION = 0.1
# More points are not fitted: enough for all modes to be known to a hundredth of the noise.
MAX_FITTED_POINTS, THINNING_SEED = 20_000, 1


@dataclass(frozen=True)
class Scan:
    """Measured points in metres and the complex amplitude there, each of shape (points,).

    Without angles it is ``is_radial``, on a line through the centre. ``origin_m`` is the centre in
    the coordinates of the file.
    ``lines`` are the rows' places in the file and ``missing`` counts points without an amplitude.
    ``has_phase_or_sign`` tells whether phase, sign or an amplitude below zero tells on which side
    of a node a point is. ``notes`` say how the file was read.
    """

    path: Path
    x_m: np.ndarray
    y_m: np.ndarray
    amplitude_m: np.ndarray
    lines: np.ndarray
    missing_count: int
    has_phase_or_sign: bool
    notes: tuple[str, ...] = ()
    is_radial: bool = False
    origin_m: tuple[float, float] = (0.0, 0.0)


def turned_to_main_phase(amplitude_m: np.ndarray) -> np.ndarray:
    """Amplitudes turned to the phase that holds most, half that of Σ u² (the major axis)."""
    return np.asarray(amplitude_m * np.exp(-0.5j * np.angle(np.sum(amplitude_m**2))))


def average_repeated_points(scan: Scan) -> Scan:
    """A scan with one point at each place, the mean of the rows there, at the first one's line.

    Rows of a place are no independent evidence of a shape between places: cross-validation holds
    them out together, and noise that they share is counted once.
    """
    steps = np.round(np.stack([scan.x_m, scan.y_m]) / SAME_POSITION_DISTANCE_M)
    _, first, position, rows = np.unique(
        steps, axis=1, return_index=True, return_inverse=True, return_counts=True
    )
    if rows.max() == 1:
        return scan
    real, imaginary = (
        np.bincount(position.ravel(), weights=part) / rows
        for part in (scan.amplitude_m.real, scan.amplitude_m.imag)
    )
    order = np.argsort(first)
    amplitude_m, kept = (real + 1j * imaginary)[order], first[order]
    columns = {name: getattr(scan, name)[kept] for name in ("x_m", "y_m", "lines")}
    note = f"{len(scan.x_m)} rows at {len(kept)} places: the mean at each place is fitted"
    return replace(scan, **columns, amplitude_m=amplitude_m, notes=(*scan.notes, note))


def limit_point_count(scan: Scan) -> Scan:
    """A scan of at most MAX_FITTED_POINTS points: itself, or as many of its points, drawn at
    random."""
    points = len(scan.x_m)
    if points <= MAX_FITTED_POINTS:
        return scan
    drawn = np.random.default_rng(THINNING_SEED).choice(points, MAX_FITTED_POINTS, replace=False)
    columns = ("x_m", "y_m", "amplitude_m", "lines")
    kept_columns = {name: getattr(scan, name)[np.sort(drawn)] for name in columns}
    note = f"{MAX_FITTED_POINTS} of {points} points are fitted, drawn at random"
    return replace(scan, **kept_columns, notes=(*scan.notes, note))


@dataclass(frozen=True)
class PointRemedies:
    """Texts of messages on the points of a file, "" where the study has settled the question.

    ``on_line`` is of points on a line, ``on_one_side`` of points all on one side of the centre,
    ``unsigned`` of amplitudes that have neither phase nor sign.
    """

    on_line: str = ""
    on_one_side: str = ""
    unsigned: str = ""


NO_REMEDIES = PointRemedies()


def list_text(values: Sequence[object]) -> str:
    """Places in a file, or values, the first of many."""
    return ", ".join(map(str, values[:MAX_LISTED_ITEMS])) + ", …" * (len(values) > MAX_LISTED_ITEMS)


def missing_points_note(numbers: Sequence[int], *, what: str) -> list[str]:
    """A note that names the points without an amplitude, if there are any."""
    many = "s" * (len(numbers) > 1)
    return [
        f"{len(numbers)} point{many} without an amplitude, excluded from profile and noise "
        f"({what}{many} {list_text(numbers)})"
    ] * bool(len(numbers))


def nearest_spectral_line(lines_hz: np.ndarray, frequency_hz: float) -> tuple[float, str]:
    """The line of a spectrum nearest to a frequency, and why it is too far from it, if it is."""
    line_hz = float(lines_hz[np.argmin(np.abs(lines_hz - frequency_hz))])
    steps_hz = np.diff(np.sort(lines_hz))
    farthest = (
        MAX_OFFSET_IN_LINE_SPACINGS * steps_hz.max(initial=0.0)
        or MAX_FREQUENCY_OFFSET_FRACTION * frequency_hz
    )
    far = (
        f"its lines go from {lines_hz.min():.7g} to {lines_hz.max():.7g} Hz, and the actuator "
        f"vibrates at {frequency_hz:.7g} Hz (actuator.frequency)"
    )
    return line_hz, far if abs(line_hz - frequency_hz) > farthest else ""
