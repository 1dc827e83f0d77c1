"""A study with an outline from a file is made anew where that file changes."""

import numpy as np

from .conftest import copy_checkout, snakemake

STUDY = """
study: patch
actuator: {frequency: 20 kHz, surface_radius: 30 mm, profile: {kind: piston}}
finger: {shape: curve, length_x: 10 mm, length_y: 8 mm, outline: {file: patch.csv}}
screen:
  h0: {start: 20 µm, stop: 35 um}
  hv: {start: 2 µm, stop: 18.5 µm, levels: 5}
extrapolation: {force: 500 mN}
"""


def oval(points: int) -> str:
    turn = 2 * np.pi * np.arange(points) / points
    rows = zip(5 * np.cos(turn), 4 * np.sin(turn), strict=True)
    return "x_mm,y_mm\n" + "".join(f"{x:.9f},{y:.9f}\n" for x, y in rows)


def test_what_reads_the_finger_is_made_anew_where_its_outline_changes(repository, tmp_path):
    folder = copy_checkout(repository, tmp_path / "checkout")
    (folder / "config/patch.yaml").write_text(STUDY, encoding="utf-8")

    def run(points: int) -> str:
        (folder / "config/patch.csv").write_text(oval(points), encoding="utf-8")
        device = "results/patch/simulations/device.json"
        done = snakemake(folder, device, "--configfile", "config/patch.yaml")
        assert done.returncode == 0, done.stdout[-2000:]
        return done.stdout

    assert "Compile the kernels" in run(60)
    assert "Nothing to be done" in run(60)
    assert "Compile the kernels" in run(80)
