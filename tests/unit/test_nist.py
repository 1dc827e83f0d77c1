"""Fits reach the certified least squares of NIST's nonlinear data sets, in any unit of force."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from squeezefilm.models.data import Factors
from squeezefilm.models.fitting import fit_model
from squeezefilm.models.force_model import make_model

SETS = yaml.safe_load(Path(__file__).with_name("nist.yaml").read_text(encoding="utf-8"))
SLOW = {"Bennett5", "Chwirut2", "Hahn1", "Kirby2"}
PER_HV = 1000.0


def fitted(name: str, factor: float):
    known = SETS[name]
    names = [f"b{number}" for number in range(1, len(known["theta"]) + 1)]
    expression = known["expression"].replace("exp", "E").replace("x", f"({PER_HV}*hv/h0)")
    entry = {"expression": expression.replace("E", "exp"), "parameters": names}
    model = make_model(name.lower(), entry, source=name)
    factors = Factors.of(h0_m=1e-5, hv_m=np.array(known["x"]) / PER_HV * 1e-5)
    force = factor * np.array(known["y"])
    return fit_model(model, factors, force, bound=100.0), model, factors


@pytest.mark.parametrize("name", sorted(SETS.keys() - SLOW))
def test_the_certified_minimum_is_found(name):
    fit, _, _ = fitted(name, 1.0)
    assert fit.sum_of_squares == pytest.approx(SETS[name]["sum_of_squares"], rel=1e-8)
    assert fit.theta == pytest.approx(SETS[name]["theta"], rel=1e-5)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
@pytest.mark.parametrize("name", ["BoxBOD", "Chwirut2", "Eckerle4", "Misra1a", "Rat42"])
def test_forces_in_another_unit_give_the_same_fit_in_that_unit(name, factor):
    fit, model, factors = fitted(name, factor)
    expected = factor * model.evaluate(SETS[name]["theta"], factors)
    assert model.evaluate(fit.theta, factors) == pytest.approx(expected, rel=1e-5)
