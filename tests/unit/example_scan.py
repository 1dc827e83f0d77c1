"""The examples' scans, config/vibrometer.csv and config/plate.csv: profiles, with noise and gaps.

The disc is the paper's with its sinc; the plate, 30 × 20 mm, has a wave of 24 mm along x that is
weaker towards its sides.
"""

import csv
import io

import numpy as np

from squeezefilm.film.profiles import Formula, Profile, Sinc
from squeezefilm.film.surfaces import Disc, Rectangle, Surface

PLATE = Rectangle(0.030, 0.020)
EXAMPLES: dict[str, tuple[Surface, Profile, float]] = {
    "disc": (Disc(9.9e-3), Sinc(wave_number_per_m=109.8), 0.75),
    "plate": (PLATE, Formula("cos(2*pi*x/0.024)*(1 - 0.2*(y/0.01)**2)", PLATE), 1.25),
}
"""Where points lie, the profile, and the raster's step in mm."""
PEAK_UM = 1.2
PHASE_NOISE_DEG = 1.0


def scan_text(*, noise: float, missing: float, seed: int, surface: str = "disc") -> str:
    """A raster over the surface as CSV text: place, amplitude and phase at each point."""
    random = np.random.default_rng(seed)
    where, profile, step_mm = EXAMPLES[surface]
    lines = (
        step_mm * np.arange(-steps, steps + 1)
        for steps in (int(1e3 * half_m / step_mm) for half_m in where.half_extents_m)
    )
    x, y = (values.ravel() for values in np.meshgrid(*lines))
    on_it = where.relative_distance(x / 1e3, y / 1e3) <= 1
    x, y = x[on_it], y[on_it]
    amplitude = profile.amplitude(x_m=x / 1e3, y_m=y / 1e3)
    measured = PEAK_UM * (amplitude + noise * random.standard_normal(len(x)))
    phase = np.where(measured < 0, 180.0, 0.0) + PHASE_NOISE_DEG * random.standard_normal(len(x))
    seen = random.uniform(size=len(x)) >= missing
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["x_mm", "y_mm", "amplitude_um", "phase_deg"])
    for row in zip(x, y, np.abs(measured), phase, seen, strict=True):
        size = f"{row[2]:.4f}" if row[4] else ""
        writer.writerow([f"{row[0]:.2f}", f"{row[1]:.2f}", size, f"{row[3]:.1f}"])
    return out.getvalue()
