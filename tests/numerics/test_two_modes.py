"""A vibrometer's table of two modes with a lag, from the scan to force, thrust and response."""

import io
import json
from contextlib import redirect_stdout

import numpy as np
import pandas as pd
import pytest
import yaml

import squeezefilm as sf
from squeezefilm.cli import main as cli

# What moves with the gap's sine, and a quarter of a period ahead of it; x and y in metres.
FIRST = "1.2*cos(6.2832*x/0.024) + 0.24*sin(6.2832*(0.6*x + 0.8*y)/0.03)"
AHEAD = "0.66*sin(6.2832*(0.6*x + 0.8*y)/0.03)"
NOISE_UM = 0.01
WHERE = {"h0": "5 um", "hv": "2 um", "x": "1 mm"}


@pytest.fixture(scope="module")
def studies(tmp_path_factory):
    """A study begun with `squeezefilm new`, its scan replaced; and the exact formula."""
    folder = tmp_path_factory.mktemp("two_modes") / "config"
    folder.mkdir()
    measured = folder / "mine.yaml"
    assert cli.main(["new", "mine", "--folder", str(folder)]) == 0
    scan = folder / "mine.csv"
    scan.write_text(_scan(), encoding="utf-8")
    study = yaml.safe_load(measured.read_text(encoding="utf-8"))
    axisymmetric = measured.with_name("axisymmetric.yaml")
    axisymmetric.write_text(yaml.safe_dump(study), encoding="utf-8")
    study["actuator"]["profile"] = {"kind": "measured", "file": scan.name}
    measured.write_text(yaml.safe_dump(study), encoding="utf-8")
    study["actuator"]["profile"] = {"kind": "formula", "expression": FIRST, "quadrature": AHEAD}
    exact = measured.with_name("exact.yaml")
    exact.write_text(yaml.safe_dump(study), encoding="utf-8")
    return measured, exact, axisymmetric


def _scan() -> str:
    """Amplitude and phase by which it leads, every 0.8 mm, with noise."""
    random, line = np.random.default_rng(2), np.linspace(-9.6, 9.6, 25)
    x, y = (each.ravel() for each in np.meshgrid(line, line))
    x, y = (each[np.hypot(x, y) < 9.9] for each in (x, y))
    second = np.sin(6.2832 * (0.6 * x + 0.8 * y) / 30)
    motion = 1.2 * np.cos(6.2832 * x / 24) + (0.24 + 0.66j) * second
    motion = motion + NOISE_UM * (random.normal(size=x.size) + 1j * random.normal(size=x.size))
    rows = zip(x, y, np.abs(motion), np.degrees(np.angle(motion)), strict=True)
    lines = ["x_mm,y_mm,amplitude_um,phase_deg"]
    return "\n".join(lines + [",".join(f"{each:.5g}" for each in row) for row in rows])


@pytest.fixture(scope="module")
def forces(studies):
    """Of the scan and of the exact formula."""
    return [sf.load(each).force(**WHERE, outputs=["thrust"]) for each in studies[:2]]


def test_force_and_thrust_are_those_of_the_modes(forces):
    measured, exact = forces
    assert measured.scan is not None
    error_n = measured.error_n + measured.row["measurement_noise_n"]
    assert measured.force_n == pytest.approx(exact.force_n, abs=error_n)
    assert error_n < 0.05 * measured.force_n
    thrust, expected = (each.solution.outputs.value["thrust_x"] for each in (measured, exact))
    assert thrust == pytest.approx(expected, rel=0.05)
    assert abs(expected) > 1e-6


def test_the_noise_of_the_scan_has_a_column_for_the_force_and_for_each_output(studies, forces):
    """``force_error_n`` is numerical in every table; the noise explains the rest."""
    alone, _ = forces
    row, true = (
        sf.load(each).curve(**WHERE, outputs=["thrust"]).iloc[0].to_dict() for each in studies[:2]
    )
    assert row["force_error_n"] == alone.row["force_error_n"] == alone.solution.force_error_n
    for name in ("measurement_noise_n", "thrust_x_measurement_noise_n"):
        assert row[name] == alone.row[name]
        assert name not in true
    for name in ("thrust_x", "thrust_y"):
        off_n, error_n = abs(row[f"{name}_n"] - true[f"{name}_n"]), row[f"{name}_error_n"]
        assert 3 * error_n < off_n < error_n + row[f"{name}_measurement_noise_n"]


def test_the_response_is_that_of_the_modes(studies):
    words = ["--h0", "5um", "--hv", "2um", "--frequencies", "30Hz,300Hz"]
    rows = []
    for study in studies[:2]:
        said = io.StringIO()
        with redirect_stdout(said):
            assert cli.main(["response", *words, "--config", str(study), "--json"]) == 0
        gains = json.loads(said.getvalue())["gains"]
        rows.append([[*each.values()][:3] for each in gains])
    measured, exact = np.array(rows)
    assert measured.shape == (2, 3)
    assert measured[:, 1] == pytest.approx(exact[:, 1], rel=0.01)
    assert measured[:, 2] == pytest.approx(exact[:, 2], abs=0.5)


def test_a_scan_that_is_not_axisymmetric_says_so(studies, capsys, tmp_path):
    for study, said in zip(studies[::2], (False, True), strict=True):
        words = ["--h0", "5um", "--hv", "2um", "--config", str(study)]
        assert cli.main(["simulate", *words]) == 0
        assert ("is not axisymmetric" in capsys.readouterr().out) == said
        assert cli.main(["simulate", *words, "--output", str(tmp_path / "forces.csv")]) == 0
        assert ("is not axisymmetric" in capsys.readouterr().err) == said


def test_the_gap_under_a_load_is_as_uncertain_as_the_scan(studies, capsys, tmp_path):
    rows = []
    for study in studies[:2]:
        output = tmp_path / f"{study.stem}.csv"
        words = ["--load", "0.2N", "--hv", "2um", "--config", str(study), "--output", str(output)]
        assert cli.main(["levitate", *words]) == 0
        rows.append(pd.read_csv(output).iloc[0])
        assert ("does not include the scan's" in capsys.readouterr().err) == (study == studies[0])
    measured, exact = rows
    assert abs(measured["h0_m"] - exact["h0_m"]) > measured["h0_error_m"] + 1e-5 * exact["h0_m"]
    error_m = measured["h0_error_m"] + measured["h0_measurement_noise_m"]
    assert measured["h0_m"] == pytest.approx(exact["h0_m"], abs=error_m)
    assert error_m < 0.05 * measured["h0_m"]
    assert exact["h0_measurement_noise_m"] == 0
