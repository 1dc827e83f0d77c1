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


def test_commands_that_read_the_finger_rest_on_its_outline(repository, tmp_path):
    folder = copy_checkout(repository, tmp_path / "checkout")
    (folder / "config/patch.yaml").write_text(STUDY, encoding="utf-8")

    def bases(points: int) -> dict[str, set[str]]:
        (folder / "config/patch.csv").write_text(oval(points), encoding="utf-8")
        words = (
            "results/patch/simulations/screen/forces.csv",
            "--configfile",
            "config/patch.yaml",
            "--dry-run",
        )
        done = snakemake(folder, *words)
        assert done.returncode == 0, done.stdout[-2000:]
        listed = (folder / "results/patch/basis").iterdir()
        return {path.name: {*path.read_text().split("\n")} for path in listed}

    first = bases(60)
    named = {name for name, lines in first.items() if any("patch.csv" in line for line in lines)}
    with_finger = {name for name, lines in first.items() if any("finger" in line for line in lines)}
    assert named
    assert named <= with_finger
    assert any(name.startswith("simulate-") for name in named)
    # Another outline is another name: what it decides is made anew.
    new = bases(80).keys() - first.keys()
    assert {name.rpartition("-")[0] for name in new} == {name.rpartition("-")[0] for name in named}
