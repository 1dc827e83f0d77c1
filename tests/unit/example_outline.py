"""A pad with an oval outline from a file: the study, and its points in mm."""

from pathlib import Path

import numpy as np

STUDY = """
study: patch
actuator: {frequency: 20 kHz, surface_radius: 30 mm, profile: {kind: piston}}
pad: {shape: curve, length_x: 10 mm, length_y: 8 mm, outline: {file: patch.csv}}
screen:
  h0: {start: 20 µm, stop: 35 um}
  hv: {start: 2 µm, stop: 18.5 µm, levels: 5}
extrapolation: {force: 500 mN}
"""
TURN = 2 * np.pi * np.arange(60) / 60
OVAL = 5 * np.cos(TURN) + 4j * np.sin(TURN)


def write_outline(
    folder: Path, z_mm: np.ndarray = OVAL, header: str = "x_mm,y_mm", unit: float = 1.0
) -> Path:
    path = folder / "patch.csv"
    rows = "".join(f"{z.real:.9g},{z.imag:.9g}\n" for z in z_mm * unit)
    path.write_text(f"{header}\n{rows}", encoding="utf-8")
    return path
