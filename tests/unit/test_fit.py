"""Least-squares fits: the same minimum from every seed and bound, and clear refusals."""

import numpy as np
import pytest
import reference_forces as known
from scipy.optimize import least_squares

from squeezefilm.models.data import Factors
from squeezefilm.models.fitting import (
    best_fit_of_bounds,
    fit_model,
    fits_of_searches,
    open_range_notes,
    parameter_ranges,
    run_differential_evolution,
)
from squeezefilm.models.force_model import make_model


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
    way = (100, run_differential_evolution, 1)
    (other,) = fits_of_searches([way], known.TWO_FACTOR, *screen)
    assert other.sum_of_squares == pytest.approx(genetic.sum_of_squares, rel=1e-9)
    assert other.method != genetic.method


def test_as_many_points_as_parameters_are_met_exactly():
    theta = (7.0, 2.0, -1.0)
    factors = Factors.of(h0_m=[10e-6, 5e-6, 5e-6], hv_m=[0.2e-6, 1.45e-6, 2e-6])
    fit = fit_model(known.TWO_FACTOR, factors, known.TWO_FACTOR.evaluate(theta, factors))
    assert fit.global_error < 1e-10
    assert fit.theta == pytest.approx(theta, rel=1e-6)


EPSILON = np.tile(np.linspace(0.05, 0.4, 6), 6)
H0_M = np.repeat(np.linspace(5e-6, 10e-6, 6), 6)
AT = Factors.of(h0_m=H0_M, hv_m=EPSILON * H0_M)


def own(expression: str):
    return make_model("own", {"expression": expression}, source="models.own")


def scattered(model, theta, share: float):
    noise = 1 + share * np.random.default_rng(1).standard_normal(len(AT))
    return model.evaluate(theta, AT) * noise


def test_of_a_step_steeper_than_the_points_resolve_its_place_is_determined():
    model = own("t0/(1 + exp(-(t1 + t2*hv/h0)))")
    force = 1e-3 + scattered(model, (1.2, -400.0, 2000.0), 1e-3)
    fit = fit_model(model, AT, force, bound=100.0)
    assert fit.global_error < 3e-3
    ranges = parameter_ranges(model, AT, force, fit.theta)
    assert [np.isfinite([each.lower, each.upper]).all() for each in ranges] == [True, False, False]
    assert open_range_notes(ranges) == ["only t1/t2 is determined by these points"]


def test_parameters_beyond_the_bounds_are_found_or_said_to_be_there():
    """A peak at 0.2, whose two parameters exceed a bound of 0.5."""
    model = own("t0*exp(-(t1*hv/h0 - t2)**2)")
    force = scattered(model, (600.0, 12.0, 2.4), 1e-3)
    runs = [fit_model(model, AT, force, bound=0.5)]
    fit, notes = best_fit_of_bounds(runs, model, AT, force)
    assert np.abs(fit.theta) == pytest.approx([600.0, 12.0, 2.4], rel=1e-2)
    assert "fit.bounds" in notes[0]
    assert not best_fit_of_bounds([fit_model(model, AT, force)], model, AT, force)[1]
