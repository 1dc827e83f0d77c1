"""The empirical models: values, limits, gradients, inverse."""

import numpy as np
import pytest
from reference_forces import FOUR_FACTOR_THETA, SCREEN_THETA

from squeezefilm.errors import InputError
from squeezefilm.models.amplitude_for_force import amplitude_for_force
from squeezefilm.models.data import Factors
from squeezefilm.models.force_model import FOUR_FACTOR, TWO_FACTOR, get_model, make_model

THETA = {
    TWO_FACTOR: np.array(SCREEN_THETA),
    FOUR_FACTOR: np.array(FOUR_FACTOR_THETA),
}
MODELS = pytest.mark.parametrize("model", [TWO_FACTOR, FOUR_FACTOR], ids=lambda m: m.name)


def some_factors() -> Factors:
    rng = np.random.default_rng(3)
    return Factors.of(
        h0_m=rng.uniform(5e-6, 10e-6, 25),
        hv_m=rng.uniform(0.2e-6, 2e-6, 25),
        phi_r_m=rng.uniform(0, 2.9e-3, 25),
        phi_deg=rng.uniform(0, 45, 25),
    )


def test_the_piston_formula_is_a_case_of_the_model():
    # Paper eq. (6): 3/2, 1 and -1 in place of the parameters.
    factors = Factors.of(h0_m=5e-6, hv_m=2e-6)
    piston = np.sqrt(1 + 1.5 * 0.16) / np.sqrt(1 - 0.16) - 1
    assert TWO_FACTOR.evaluate([1.5, 1.0, -1.0], factors) == pytest.approx([piston], rel=1e-14)


def test_position_enters_in_degrees_over_45_and_in_metres():
    factors = Factors.of(h0_m=5e-6, hv_m=2e-6, phi_r_m=2e-3, phi_deg=30)
    t0, t1, t2, t3, t4 = THETA[FOUR_FACTOR]
    q = 1 + t3 * 30 / 45 + t4 * 0.002
    by_hand = np.sqrt(1 + t0 * 0.16) / np.sqrt(1 - t1 * q * 0.16) + t2
    assert FOUR_FACTOR.evaluate(THETA[FOUR_FACTOR], factors) == pytest.approx([by_hand], rel=1e-14)


@MODELS
def test_gradient_agrees_with_finite_differences(model):
    theta, factors = THETA[model], some_factors()
    gradient = model.gradient(theta, factors)
    assert gradient.shape == (25, len(theta))
    for index in range(len(theta)):
        step = np.zeros_like(theta)
        step[index] = 1e-5 * max(1, abs(theta[index]))
        ahead, back = (model.evaluate(theta + sign * step, factors) for sign in (1, -1))
        difference = (ahead - back) / (2 * step[index])
        np.testing.assert_allclose(gradient[:, index], difference, rtol=1e-6, atol=1e-10)


@pytest.mark.parametrize("theta", [[-1e3, 1.9, -1], [7.6, 1e3, -1]])
def test_an_undefined_root_is_not_a_number(theta):
    factors = Factors.of(h0_m=5e-6, hv_m=2e-6)
    assert np.isnan(TWO_FACTOR.evaluate(theta, factors)).all()
    assert np.isnan(TWO_FACTOR.gradient(theta, factors)).all()


def test_a_point_without_a_derivative_is_refused_by_name():
    model = make_model(
        "kink", {"expression": "t0*(hv/h0)**2*abs(t1*x - y)"}, place="C: models.kink"
    )
    factors = Factors.of(h0_m=5e-6, hv_m=2e-6, x_m=[0.0, 2e-3, 1e-3], y_m=[0.0, 3e-3, 1e-3])
    assert np.isfinite(model.gradient([2.0, 3.0], factors)).all()
    with pytest.raises(InputError, match=r"C: models\.kink.*abs\(t1\*x - y\).* to t1 .*x_m 0\.001"):
        model.gradient([2.0, 1.0], factors)


@MODELS
@pytest.mark.parametrize("force_n", [0.01, 0.5, 1.0, 3.0])
def test_amplitude_for_force_inverts_the_model(model, force_n):
    where = {"h0_m": 5e-6, "phi_r_m": 1e-3, "phi_deg": 15.0}
    hv_m = amplitude_for_force(model, THETA[model], force_n=force_n, **where)
    back = model.evaluate(THETA[model], Factors.of(hv_m=hv_m, **where))
    assert back == pytest.approx([force_n], rel=1e-12)


@pytest.mark.parametrize("force_n", [-0.5, -5.0, -1.0013 + 0.5, float("nan")])
def test_a_force_that_no_amplitude_gives_is_refused(force_n):
    with pytest.raises(InputError, match="force_n"):
        amplitude_for_force(TWO_FACTOR, THETA[TWO_FACTOR], force_n=force_n, h0_m=5e-6)


def test_a_force_beyond_contact_is_refused():
    # theta1 < 1: the model stays finite up to contact, at 1.73 N for these parameters.
    theta = [1.5, 0.5, -0.5]
    contact = np.sqrt(2.5 / 0.5) - 0.5
    below = amplitude_for_force(TWO_FACTOR, theta, force_n=contact - 1e-3, h0_m=5e-6)
    assert 4.9e-6 < below < 5e-6
    with pytest.raises(InputError, match="below contact"):
        amplitude_for_force(TWO_FACTOR, theta, force_n=contact + 1e-3, h0_m=5e-6)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"h0_m": [5e-6, np.nan]}, "h0_m: .*finite"),
        ({"h0_m": 0.0}, "h0_m: .*positive"),
        ({"h0_m": [5e-6, 6e-6, 7e-6], "phi_deg": [0, 45]}, "different lengths"),
    ],
)
def test_bad_factors_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        Factors.of(**({"h0_m": 5e-6, "hv_m": 1e-6} | wrong))


def test_wrong_shapes_and_names_are_refused():
    with pytest.raises(InputError, match="3 parameters"):
        TWO_FACTOR.evaluate([1.0, 2.0], some_factors())
    with pytest.raises(InputError, match="h0_m, hv_m"):
        TWO_FACTOR.factors(np.ones((3, 4)))
    with pytest.raises(InputError, match="two_factor, four_factor"):
        get_model("three_factor")
