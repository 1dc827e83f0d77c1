"""The empirical models: values, limits, gradients, inverse."""

import numpy as np
import pytest
from reference_forces import FOUR_FACTOR_THETA, SCREEN_THETA

from squeezefilm.io.errors import InputError
from squeezefilm.models.amplitude_for_force import amplitude_for_force, gap_for_force
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


def test_four_factors_reduce_to_two_where_the_position_has_no_effect():
    theta = THETA[TWO_FACTOR]
    moved = FOUR_FACTOR.evaluate([*theta, 0, 0], some_factors())
    np.testing.assert_allclose(moved, TWO_FACTOR.evaluate(theta, some_factors()), rtol=1e-14)


def test_position_enters_in_degrees_over_45_and_in_metres():
    factors = Factors.of(h0_m=5e-6, hv_m=2e-6, phi_r_m=2e-3, phi_deg=30)
    t0, t1, t2, t3, t4 = THETA[FOUR_FACTOR]
    q = 1 + t3 * 30 / 45 + t4 * 0.002
    by_hand = np.sqrt(1 + t0 * 0.16) / np.sqrt(1 - t1 * q * 0.16) + t2
    assert FOUR_FACTOR.evaluate(THETA[FOUR_FACTOR], factors) == pytest.approx([by_hand], rel=1e-14)


@MODELS
def test_without_vibration_the_force_is_one_plus_theta2(model):
    # Paper eq. (13): the limit is zero just when theta2 is -1.
    still = Factors.of(h0_m=[5e-6, 10e-6], hv_m=0.0, phi_r_m=1e-3, phi_deg=20)
    force = model.evaluate(THETA[model], still)
    np.testing.assert_allclose(force, 1 + THETA[model][2], rtol=0, atol=1e-15)


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


@MODELS
def test_a_population_is_evaluated_as_its_members_are(model):
    population = THETA[model] * np.array([[0.5], [1.0], [1.5]])
    together = model.evaluate(population, some_factors())
    assert together.shape == (3, 25)
    for row, theta in zip(together, population, strict=True):
        np.testing.assert_array_equal(row, model.evaluate(theta, some_factors()))


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


@MODELS
@pytest.mark.parametrize("load_n", [0.3, 0.5])
def test_gap_for_force_inverts_the_model(model, load_n):
    where = {"hv_m": 2e-6, "phi_r_m": 1e-3, "phi_deg": 15.0}
    h0_m = gap_for_force(model, THETA[model], force_n=load_n, gaps_m=(5e-6, 10e-6), **where)
    assert 5e-6 < h0_m < 10e-6
    back = model.evaluate(THETA[model], Factors.of(h0_m=h0_m, **where))
    assert back == pytest.approx([load_n], rel=1e-9)


def test_the_widest_of_two_gaps_is_where_a_part_comes_to_rest():
    settings = {"expression": "t0*(hv/h0 - 0.1)*(0.2 - hv/h0)"}
    hump = make_model("hump", settings, place="here")
    found = gap_for_force(hump, [1000.0], force_n=1.6, hv_m=1e-6, gaps_m=(4e-6, 10e-6))
    assert found == pytest.approx(1e-6 / 0.12, rel=1e-9)


@pytest.mark.parametrize(
    ("hv_m", "load_n", "message"),
    [(2e-6, 5.0, "for no gap"), (2e-6, 0.001, "for no gap"), (1e-5, 0.5, "touch at every gap")],
)
def test_a_load_that_no_gap_carries_is_refused(hv_m, load_n, message):
    with pytest.raises(InputError, match=message):
        gap_for_force(
            *(TWO_FACTOR, THETA[TWO_FACTOR]), force_n=load_n, hv_m=hv_m, gaps_m=(5e-6, 1e-5)
        )


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
