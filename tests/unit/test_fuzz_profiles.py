"""Scans, profiles and fingers with anything wrong in them run, or are refused with the place named.

Mutations are drawn with fixed seeds: a failure comes again.
"""

import math
import random
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from squeezefilm.cli.study.example_scan import scan_text
from squeezefilm.film.measured.smooth import smoothed_scan
from squeezefilm.film.surfaces import Disc
from squeezefilm.io.errors import InputError
from squeezefilm.studies.config import load_config
from squeezefilm.studies.study import check_study

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
        smoothed_scan.cache_clear()
        axisymmetric = draw.random() < 0.7
        try:
            smoothed = smoothed_scan(path, surface=Disc(RADIUS_M), axisymmetric=axisymmetric)
        except InputError as error:
            message = str(error)
            assert "scan.csv" in message
            if "finite number" in message or "cells" in message:
                assert re.search(r"line \d+", message)
            continue
        ran += 1
        values = smoothed.profile.amplitude(x_m=x_m, y_m=y_m)
        assert np.all(np.abs(values) <= smoothed.profile.largest + 1e-6)
        assert np.isfinite(smoothed.noise_m)
    assert 5 <= ran <= 55  # some of both


VALUES: list[Any] = [0, 1, -1, 1e-300, 1e300, 0.01, 5e-6, 90, -361, 2**60, None, True, "", "sinc"]
VALUES += [[], {}, [1], {"kind": "piston"}, ".nan", "1e", "../../etc/passwd", "x" * 2000, "piston"]
PROFILES: list[dict[str, Any]] = [
    {"kind": "sinc", "wave_number_per_m": 109.8},
    {"kind": "piston"},
    {"kind": "standing-wave", "wavelength_m": 0.02, "direction_deg": 30, "crest_m": 0.001},
    {
        "kind": "bessel",
        "nodal_diameters": 2,
        "wave_number_rad_per_m": 400,
        "edge_share": 0.01,
        "direction_deg": 0,
    },
    {"kind": "formula", "expression": "cos(200*x) * exp(-(r/0.02)**2)"},
    {"kind": "measured", "file": "scan.csv", "axisymmetric": False},
]
FINGER: dict[str, Any] = {
    "shape": "ellipse",
    "length_x_m": 0.008,
    "length_y_m": 0.006,
    "rotation_deg": 20,
    "speed_x_m_per_s": 0,
    "gap": {"tilt_x_m": 1e-6, "tilt_y_m": 0, "bulge_m": 1e-6},
}


def study(repository: Path) -> dict[str, Any]:
    return {**load_config(repository / "config" / "paper.yaml")}


@pytest.mark.parametrize("block", range(2))
def test_a_profile_and_a_finger_run_or_are_refused(block, repository, tmp_path):
    draw = random.Random(block)
    (tmp_path / "scan.csv").write_text("\n".join(SCAN), encoding="utf-8")
    path = tmp_path / "study.yaml"
    accepted = 0
    for _ in range(15):
        whole = study(repository)
        profile, finger = dict(draw.choice(PROFILES)), {**FINGER, "gap": dict(FINGER["gap"])}
        whole["actuator"] = {**whole["actuator"], "profile": profile}
        whole["finger"] = finger
        for _ in range(draw.randint(0, 2)):
            section = draw.choice([profile, finger, finger.get("gap")])
            if not isinstance(section, dict):
                continue
            key = draw.choice([*section, "colour"])
            if draw.random() < 0.3:
                section.pop(key, None)
            else:
                section[key] = draw.choice(VALUES)
        path.write_text(yaml.safe_dump(whole), encoding="utf-8")
        try:
            check_study(load_config(path))
            message = ""
        except InputError as error:
            message = str(error)
        assert not message or re.search(r"study\.yaml|scan\.csv|etc/passwd", message), message
        accepted += not message
    assert 2 <= accepted <= 14  # some of both
