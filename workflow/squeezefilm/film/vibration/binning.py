"""More points than a fit needs, averaged over small cells.

Averages keep what the points say together, but for the profile's curvature within a cell, which
``averaging_loss`` bounds.
"""

from dataclasses import replace

import numpy as np

from squeezefilm.film.vibration.shapes import Modes
from squeezefilm.film.vibration.vibrometer import Scan

MOST_POINTS = 20_000
WIDER = 1.05


def binned(scan: Scan) -> Scan:
    """A scan of at most MOST_POINTS: itself, or the means over cells of its points."""
    if len(scan.x_m) <= MOST_POINTS:
        return scan
    places = [scan.x_m] if scan.y_m is None else [scan.x_m, scan.y_m]
    extents = [float(np.ptp(each)) or 1e-12 for each in places]
    width = float(np.prod(extents) / MOST_POINTS) ** (1 / len(places))
    while True:
        cell = np.zeros(len(scan.x_m), dtype=np.int64)
        for each, extent in zip(places, extents, strict=True):
            cell = cell * (int(extent / width) + 2) + ((each - each.min()) / width).astype(np.int64)
        _, first, inverse, counts = np.unique(
            cell, return_index=True, return_inverse=True, return_counts=True
        )
        if len(first) <= MOST_POINTS:
            break
        width *= WIDER

    def mean(values: np.ndarray) -> np.ndarray:
        means: np.ndarray = np.bincount(inverse, weights=values) / counts
        return means

    amplitude = mean(scan.amplitude_m.real) + 1j * mean(scan.amplitude_m.imag)
    note = (
        f"{len(scan.x_m)} points averaged over {len(first)} cells {width * 1e3:.3g} mm wide, each "
        "named by the line of its first point"
    )
    return replace(
        scan,
        x_m=mean(scan.x_m),
        y_m=None if scan.y_m is None else mean(scan.y_m),
        amplitude_m=amplitude,
        lines=scan.lines[first],
        cell_m=width,
        notes=(*scan.notes, note),
    )


def averaging_loss(profile: Modes, *, cell_m: float, x_m: np.ndarray, y_m: np.ndarray) -> float:
    """By how much means over cells are off the profile at most, in units of its maximum.

    Over a square of the width w the mean is off the value at its centre by w²/24 (s_xx + s_yy), to
    leading order; the derivatives by differences over w.
    """
    if not cell_m:
        return 0.0
    around = [(cell_m, 0.0), (-cell_m, 0.0), (0.0, cell_m), (0.0, -cell_m)]
    near = [profile.amplitude(x_m=x_m + dx, y_m=y_m + dy) for dx, dy in around]
    centre = profile.amplitude(x_m=x_m, y_m=y_m)
    return float(np.abs(sum(near) - 4 * centre).max() / 24)
