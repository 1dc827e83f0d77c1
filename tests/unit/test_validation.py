"""Errors of a model against simulations."""

import numpy as np
import pytest

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
