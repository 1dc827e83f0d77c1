"""Errors of a model against simulations."""

import numpy as np
import pytest

from squeezefilm.io.errors import InputError
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


def test_a_set_without_its_file_is_refused(study, tmp_path, refused):
    forces = [f"{study.root}/simulations/{plan}/forces.csv" for plan in ("screen", "error_map")]
    options = [f"--config={study.config}", f"--output={tmp_path}/a.csv", f"--summary={tmp_path}/a"]
    assert "--output: 1 files for 2 sets" in refused(
        "validate", f"{study.root}/fits/screen.json", *forces, *options
    )
    assert not list(tmp_path.iterdir())
