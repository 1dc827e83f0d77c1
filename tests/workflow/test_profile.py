"""What is made from a study's scan or outline is made anew where its file changes."""

import numpy as np
import pytest

from .conftest import copy_checkout, snakemake

PATCH = """
study: patch
actuator: {frequency: 20 kHz, surface_radius: 30 mm, profile: {kind: piston}}
finger: {shape: curve, length_x: 10 mm, length_y: 8 mm, outline: {file: patch.csv}}
screen:
  h0: {start: 20 µm, stop: 35 um}
  hv: {start: 2 µm, stop: 18.5 µm, levels: 5}
extrapolation: {force: 500 mN}
"""
TURN = 2 * np.pi * np.arange(60) / 60


@pytest.mark.parametrize(
    ("study", "target", "message"),
    [
        ("vibrometer", "profile/smoothed.npz", "Make a smooth profile of the scan"),
        ("patch", "simulations/device.json", "Compile the kernels"),
    ],
)
def test_a_changed_file_is_read_again(study, target, message, repository, tmp_path):
    folder = copy_checkout(repository, tmp_path / "checkout")
    (folder / "config/patch.yaml").write_text(PATCH, encoding="utf-8")
    oval = "".join(f"{5 * np.cos(at):.9f},{4 * np.sin(at):.9f}\n" for at in TURN)
    (folder / "config/patch.csv").write_text(f"x_mm,y_mm\n{oval}", encoding="utf-8")
    words = (f"results/{study}/{target}", "--configfile", f"config/{study}.yaml")
    done = snakemake(folder, *words)
    assert done.returncode == 0, done.stdout[-2000:]
    assert "Nothing to be done" in snakemake(folder, *words).stdout
    with (folder / f"config/{study}.csv").open("a", encoding="utf-8") as file:
        file.write("\n")
    assert message in snakemake(folder, *words, "--dry-run").stdout
