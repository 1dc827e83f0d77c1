"""Least-squares fits: the same minimum from every seed and bound, and clear refusals."""

import numpy as np
import pytest
import reference_forces as known
from scipy.optimize import least_squares

from squeezefilm.models.data import Factors
from squeezefilm.models.fitting import evolution, fit_model


@pytest.fixture(scope="module")
def screen():
    return known.reference_forces("screen")


@pytest.fixture(scope="module")
def four():
    return known.reference_forces("four_factor")


@pytest.mark.parametrize(("bound", "seed"), [(1e6, 1), (1e6, 2), (100.0, 3)])
def test_the_screen_has_one_best_fit(screen, bound, seed):
    fit = fit_model(known.TWO_FACTOR, *screen, bound=bound, seed=seed)
    assert fit.global_error == pytest.approx(0.00533, abs=0.00002)
    assert fit.theta == pytest.approx(known.SCREEN_THETA, rel=1e-4)


@pytest.mark.parametrize(("case", "bound"), [("screen", 100.0), ("four", 1e6), ("four", 100.0)])
def test_the_simplex_arrives_where_a_method_with_derivatives_does(case, bound, request):
    model = known.TWO_FACTOR if case == "screen" else known.FOUR_FACTOR
    factors, force = request.getfixturevalue(case)
    fit = fit_model(model, factors, force, bound=bound)
    check = least_squares(
        lambda theta: model.evaluate(theta, factors) - force,
        np.array(fit.theta) * 1.001,
        jac=lambda theta: model.gradient(theta, factors),
        x_scale=np.abs(fit.theta),
        **dict.fromkeys(("xtol", "ftol", "gtol"), 1e-15),
    )
    assert fit.sum_of_squares == pytest.approx(2 * check.cost, rel=1e-10)
    assert fit.theta == pytest.approx(check.x, rel=1e-5)
    if model is known.FOUR_FACTOR:
        assert fit.global_error == pytest.approx(0.01222, abs=0.00005)
        assert fit.theta == pytest.approx(known.FOUR_FACTOR_THETA, rel=1e-4)


def test_differential_evolution_finds_the_same(screen):
    genetic = fit_model(known.TWO_FACTOR, *screen)
    other = fit_model(known.TWO_FACTOR, *screen, bound=100, search=evolution)
    assert other.sum_of_squares == pytest.approx(genetic.sum_of_squares, rel=1e-9)
    assert other.method != genetic.method


def test_as_many_points_as_parameters_are_met_exactly():
    theta = (7.0, 2.0, -1.0)
    factors = Factors.of(h0_m=[10e-6, 5e-6, 5e-6], hv_m=[0.2e-6, 1.45e-6, 2e-6])
    fit = fit_model(known.TWO_FACTOR, factors, known.TWO_FACTOR.evaluate(theta, factors))
    assert fit.global_error < 1e-10
    assert fit.theta == pytest.approx(theta, rel=1e-6)
