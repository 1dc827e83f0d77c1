"""Errors of a model against simulations."""

import numpy as np
import pandas as pd
import pytest
from changed_sections import changed

from squeezefilm.config.loading import load_config
from squeezefilm.models.fit_file import fit_from_values
from squeezefilm.studies.tasks.fits import errors_of_fit

BAND = {"relative_error_band": 0.2}
SIMULATION = [1.0, 2.0, 4.0, 0.1]
MODEL = np.array([1.1, 2.0, 3.0, 0.115])


def test_summary(repository):
    values = {"model": "own", "expression": "t0*hv/h0", "theta": [10.0], "points": 4}
    values |= {"parameters": ["t0"], "parameter_units": ["N"]}
    fit = fit_from_values(values | {"global_error": 0.0, "sum_of_squares": 0.0}, source="fit.json")
    forces = pd.DataFrame({"point_id": list("abcd"), "h0_m": 1e-5, "hv_m": 1e-6 * MODEL})
    forces = forces.assign(phi_r_m=0.0, phi_deg=0.0, force_n=SIMULATION)
    config = changed(load_config(repository / "config/quick.yaml"), validation=BAND)
    _, summary = errors_of_fit(fit, forces, config)
    squares = 0.1**2 + 1.0**2 + 0.015**2
    assert summary["points"] == 4
    assert summary["sum_of_squares"] == pytest.approx(squares)
    assert summary["global_error"] == pytest.approx(np.sqrt(squares / 21.01))
    assert summary["fraction_within_band"] == 0.75
    assert summary["worst_point_id"] == "c"
    assert summary["worst_relative_error"] == pytest.approx(-0.25)
    assert summary["band"] == 0.2
