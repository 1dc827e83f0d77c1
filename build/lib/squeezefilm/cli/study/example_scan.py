"""Write a vibrometer's table of the paper's actuator: its sinc, with noise and missing points.

    squeezefilm example-scan --output config/vibrometer.csv

Equal options give the same file, byte for byte; without any they give the one in config/.
"""

import argparse
import csv
import io

import numpy as np

from squeezefilm.film.vibration.shapes import Sinc
from squeezefilm.io.atomic import write_text
from squeezefilm.io.errors import InputError

PROFILE = Sinc(wave_number_per_m=109.8)
RADIUS_MM, STEP_MM = 9.9, 0.75
PEAK_UM = 1.2
PHASE_NOISE_DEG = 1.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--output", required=True, metavar="SCAN.csv")
    parser.add_argument("--noise", type=float, default=0.02, help="share of the largest amplitude")
    parser.add_argument("--missing", type=float, default=0.03, help="share of the points")
    parser.add_argument("--seed", type=int, default=1)


def run(options: argparse.Namespace) -> None:
    if not (0 <= options.noise <= 1 and 0 <= options.missing <= 0.9 and options.seed >= 0):
        raise InputError("--noise lies in 0 … 1, --missing in 0 … 0.9, --seed is not negative")
    text = scan_text(noise=options.noise, missing=options.missing, seed=options.seed)
    write_text(text, options.output)


def scan_text(*, noise: float, missing: float, seed: int) -> str:
    """A raster over the disc as CSV text: place, amplitude and phase at each point."""
    random = np.random.default_rng(seed)
    steps = int(RADIUS_MM / STEP_MM)
    line = STEP_MM * np.arange(-steps, steps + 1)
    x, y = (values.ravel() for values in np.meshgrid(line, line))
    on_disc = np.hypot(x, y) <= RADIUS_MM
    x, y = x[on_disc], y[on_disc]
    amplitude = PROFILE.amplitude(x_m=x / 1e3, y_m=y / 1e3)
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
