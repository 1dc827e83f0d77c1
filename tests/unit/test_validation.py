"""Errors of a model against simulations."""

import json

import numpy as np
import pytest

from squeezefilm.cli.main import main
from squeezefilm.errors import InputError
from squeezefilm.models.cross_validation import summarise

SIMULATION = [1.0, 2.0, 4.0, 0.1]
MODEL = [1.1, 2.0, 3.0, 0.115]


def test_summary():
    summary = summarise(model_n=MODEL, simulation_n=SIMULATION, band=0.2)
    squares = 0.1**2 + 1.0**2 + 0.015**2
    assert summary["points"] == 4
    assert summary["sum_of_squares"] == pytest.approx(squares)
    assert summary["global_error"] == pytest.approx(np.sqrt(squares / 21.01))
    assert summary["share_within_band"] == 0.75
    assert summary["worst_index"] == 2
    assert summary["worst_relative_error"] == pytest.approx(-0.25)
    assert summary["band"] == 0.2


@pytest.mark.parametrize(
    ("model", "simulation", "message"),
    [
        ([1.0], [1.0, 2.0], "1 modelled and 2 simulated"),
        ([], [], "no points"),
        ([np.nan], [1.0], "model_n"),
        ([1.0], [np.inf], "simulation_n"),
        ([1.0], [0.0], "zero"),
    ],
)
def test_bad_forces_are_refused(model, simulation, message):
    with pytest.raises(InputError, match=message):
        summarise(model_n=model, simulation_n=simulation, band=0.15)


def test_a_fit_is_compared_with_a_table_as_in_its_study(study, tmp_path, capsys):
    fit = f"{study.root}/fits/two_factor_design.json"
    forces = f"{study.root}/simulations/screen/forces.csv"
    output = tmp_path / "errors.csv"
    assert main(["validate", fit, forces, f"--config={study.config}", f"--output={output}"]) == 0
    made = study.root / "validation/two_factor_design_on_screen.csv"
    assert output.read_bytes() == made.read_bytes()
    summary = json.loads(made.with_suffix(".json").read_text())
    assert f"{summary['global_error']:.6g}" in capsys.readouterr().out
