"""Scans with anything wrong in them run, or are refused with the place named.

Mutations are drawn with fixed seeds: a failure comes again.
"""

import math
import random
import re

import numpy as np
import pytest
from example_scan import scan_text

from squeezefilm.errors import InputError
from squeezefilm.film.measured.smooth import smoothed_scan_of_file
from squeezefilm.film.profiles import ScanFile
from squeezefilm.film.surfaces import Disc

RADIUS_M = 0.01
# Every fourth point of the example, so that a fit takes a millisecond.
LINES = scan_text(noise=0.02, missing=0.1, seed=1).splitlines()
SCAN = [LINES[0], *LINES[1::4]]
RADIAL = ["r_mm,amplitude_um", *(f"{r / 4:g},{math.cos(r / 30):.4f}" for r in range(40))]
CELLS = ["", "nan", "NaN", "inf", "-inf", "1e999", "-1", "0", "1e-300", "1e300", "9" * 400, "1_0"]
CELLS += ["0x10", "1,5", "«", "\x00", '"', "'", "#", "None", "true", "1;2", " 3 ", "٣"]
NAMES = ["x", "x_mm", "X_mm", "y_um", "r_m", "phi_deg", "phi_rad", "amplitude_nm", "amplitude"]
NAMES += ["phase_deg", "sign", "sign_m", "time_s", "", "x_mm_mm", "_mm", "amplitude_°"]


def mutated(lines: list[str], draw: random.Random) -> str:
    """A table with up to three things done to it."""
    lines = list(lines)
    for _ in range(draw.randint(0, 3)):
        row = draw.choice([0, draw.randrange(len(lines))])
        cells, what = lines[row].split(","), draw.randrange(7)
        column = draw.randrange(len(cells))
        if what <= 1:
            cells[column] = draw.choice(CELLS if row else NAMES)
        elif what == 2:
            cells.append(draw.choice(CELLS))
        elif what == 3:
            del cells[column]
        elif what == 4:
            cells[column] += draw.choice(['"', "\r", "\x00", "\n", "é"])
        elif what == 5:
            lines = lines[: row + 1]
        else:
            lines.append(lines[row])
        lines[row] = ",".join(cells)
    return "\n".join(lines)


@pytest.mark.parametrize("block", range(2))
def test_a_scan_runs_or_is_refused(block, tmp_path):
    draw = random.Random(block)
    path = tmp_path / "scan.csv"
    line = np.linspace(-0.007, 0.007, 5)
    x_m, y_m = np.meshgrid(line, line)
    ran = 0
    for _ in range(60):
        path.write_text(mutated(draw.choice([SCAN, RADIAL]), draw), encoding="utf-8", newline="")
        axisymmetric = draw.random() < 0.7
        try:
            settings = ScanFile("scan.csv", axisymmetric=axisymmetric)
            smoothed = smoothed_scan_of_file(path, settings, Disc(RADIUS_M), frequency_hz=43270.0)
        except InputError as error:
            message = str(error)
            assert "scan.csv" in message
            if "finite number" in message or "cells" in message:
                assert re.search(r"line \d+", message)
            continue
        ran += 1
        values = smoothed.profile.amplitude(x_m=x_m, y_m=y_m)
        assert np.all(np.abs(values) <= smoothed.profile.largest_magnitude + 1e-6)
        assert np.isfinite(smoothed.noise_m)
    assert 5 <= ran <= 55  # some of both
